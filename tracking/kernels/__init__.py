"""Compiled kernels of the tracker: small, free of Python objects, nogil, cached."""
