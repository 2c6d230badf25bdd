"""Who keeps a station's worker: this process, this process for others too, or another machine."""

from __future__ import annotations

from collections.abc import Callable

from snapfit.server.fleet.keeper import Keeper
from snapfit.server.pose_store import PoseStore
from snapfit.server.supervisor import Supervisor
from snapfit.server.worker_spec import WorkerSpec

MakeKeeper = Callable[[WorkerSpec, PoseStore], Keeper]
"""Makes the keeper of a station's worker, which says what it has to say in this store."""

MEMORY = "memory"
"""The store that is this machine's shared memory alone."""


def keep_here(spec: WorkerSpec, store: PoseStore) -> Keeper:
    """A worker of this process."""
    return Supervisor(spec, store)


def listen_at(url: str) -> MakeKeeper:
    """A worker of another machine, heard of at this Redis or Valkey."""
    from snapfit.server.fleet.subscriber import Subscriber  # Redis is for several machines alone

    return lambda spec, store: Subscriber(url, spec, store)


def publish_at(url: str) -> MakeKeeper:
    """A worker of this process, told of at this Redis or Valkey."""
    from snapfit.server.fleet.publisher import Publisher

    return lambda spec, store: Publisher(url, spec, store, Supervisor(spec, store))


def keeper_for(store: str) -> MakeKeeper:
    """How an API with this `store` setting has its workers."""
    return keep_here if store == MEMORY else listen_at(store)
