"""Who looks: clients speak HTTP only and import nothing of ours."""
