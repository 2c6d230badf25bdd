"""The assembly state at run time: which links hold, which step is done, what sits wrong."""
