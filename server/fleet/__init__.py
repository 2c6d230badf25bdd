"""Several machines: workers publish on Redis or Valkey, API replicas answer from what they hear.

Redis is on nobody's way. A worker writes into the shared memory of its own machine and never
waits; a thread beside it publishes from there. An API replica answers from the shared memory of
its own machine; a thread beside it writes there what it hears.
"""
