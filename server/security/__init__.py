"""Who may ask, how much, and from where: keys, sessions, limits, headers."""
