"""Recordings of what a station saw and said, as MCAP files; and their replay."""
