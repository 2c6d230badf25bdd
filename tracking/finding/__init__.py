"""Finding parts without a pose to begin with: what a finder is, and one that needs no training."""
