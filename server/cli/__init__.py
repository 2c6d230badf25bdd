"""The `snapfit` command line."""
