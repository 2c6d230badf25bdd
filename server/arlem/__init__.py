"""ARLEM, IEEE 1589-2020: an asset's steps for players of augmented reality learning experiences."""
