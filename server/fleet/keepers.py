"""What stands behind a station: this process, this process for others too, or another machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from snapfit.server.anchor_shelf import AnchorShelf, LocalShelf
from snapfit.server.fleet.keeper import Keeper
from snapfit.server.pose_store import PoseStore
from snapfit.server.supervisor import Supervisor
from snapfit.server.worker_spec import DEMO_SOURCE, WorkerSpec


@dataclass(frozen=True)
class Backing:
    """What a station stands on.

    Attributes:
        keeper: of its worker.
        shelf: of its anchors.
    """

    keeper: Keeper
    shelf: AnchorShelf


Back = Callable[[WorkerSpec, PoseStore], Backing]
"""Makes what stands behind a station, which says what it has to say in this store."""

MEMORY = "memory"
"""The store that is this machine's shared memory alone."""


def back_here(spec: WorkerSpec, store: PoseStore, file: Path | None = None) -> Backing:
    """A worker of this process; its anchors outlive the process in a file, if there is one."""
    return Backing(Supervisor(spec, store), LocalShelf(file, spec.source))


def listen_at(url: str) -> Back:
    """A worker of another machine, heard of at this Redis or Valkey."""
    # Redis is for several machines alone.
    from snapfit.server.fleet.subscriber import Subscriber

    def back(spec: WorkerSpec, store: PoseStore) -> Backing:
        subscriber = Subscriber(url, spec, store)
        return Backing(subscriber, subscriber.shelf)

    return back


def publish_at(url: str) -> Back:
    """A worker of this process, told of at this Redis or Valkey."""
    from snapfit.server.fleet.publisher import Publisher

    def back(spec: WorkerSpec, store: PoseStore) -> Backing:
        return Backing(Publisher(url, spec, store, Supervisor(spec, store)), LocalShelf())

    return back


def backing_for(store: str, folder: Path) -> Back:
    """What stands behind the stations of an API with this `store` setting.

    Args:
        store: of the settings.
        folder: in which anchors outlive the API, where they are not in the store.
    """
    if store != MEMORY:
        return listen_at(store)

    def back(spec: WorkerSpec, store: PoseStore) -> Backing:
        # The simulated bench begins anew each time, and so do its anchors.
        is_real = spec.source != DEMO_SOURCE
        return back_here(
            spec, store, folder / "anchors" / f"{spec.station}.json" if is_real else None
        )

    return back
