"""How others see it: the worker, the pose store, the HTTP API, the command line."""
