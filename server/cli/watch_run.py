"""How `snapfit watch` runs: follows a station by the Python client and shows what it says."""

from __future__ import annotations

import asyncio
import os
import sys
import time
from contextlib import aclosing
from dataclasses import dataclass

from rich.console import Console
from rich.live import Live

from snapfit.clients.python import (
    AsyncClient,
    ClientError,
    Convention,
    NoPosesYetError,
    PoseSnapshot,
)
from snapfit.server.cli.watch_view import Watched, line, view
from snapfit.server.errors import WatchError

_REDRAWS_PER_S = 8
_LINE_S = 1.0


@dataclass(frozen=True)
class WatchOptions:
    """What the command line was told."""

    url: str
    station: str | None
    key: str | None
    verify: bool | str
    convention: str
    frame: str
    once: bool
    as_json: bool


def run(options: WatchOptions, console: Console | None = None) -> bool:
    """Until it is interrupted, or once.

    Returns:
        Whether the last snapshot can be relied on.

    Raises:
        WatchError: there is nothing to watch, and waiting is no use.
    """
    try:
        return asyncio.run(_watch(options, console or Console()))
    except KeyboardInterrupt:
        return True
    except BrokenPipeError:  # who reads has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return True
    except (ClientError, ValueError, OSError) as error:
        raise WatchError(str(error)) from error


async def _watch(options: WatchOptions, console: Console) -> bool:
    async with AsyncClient(
        options.url, station=options.station, key=options.key, verify=options.verify
    ) as client:
        if options.once:
            return await _once(client, options, console)
        if options.as_json:
            await _write_lines(client, options)
            return True
        watched = Watched(options.url)
        readers = [
            asyncio.create_task(_follow(client, options, watched)),
            asyncio.create_task(_listen(client, watched)),
        ]
        try:
            if console.is_terminal:
                await _draw(watched, console, readers)
            else:
                await _tell(watched, readers)
        finally:
            for reader in readers:
                reader.cancel()
            await asyncio.gather(*readers, return_exceptions=True)
        return True


async def _once(client: AsyncClient, options: WatchOptions, console: Console) -> bool:
    convention = Convention(options.convention)
    try:
        snapshot = await client.poses(convention=convention, frame=options.frame)
    except NoPosesYetError as error:
        Console(stderr=True, soft_wrap=True, highlight=False).print(str(error), markup=False)
        return False
    if options.as_json:
        _write(_json(snapshot))
    else:
        watched = Watched(options.url)
        watched.take(snapshot)
        console.print(view(watched, with_events=False))
    return not snapshot.stale


async def _write_lines(client: AsyncClient, options: WatchOptions) -> None:
    convention = Convention(options.convention)
    async with aclosing(client.follow(convention=convention, frame=options.frame)) as snapshots:
        async for snapshot in snapshots:
            _write(_json(snapshot))


def _json(snapshot: PoseSnapshot) -> str:
    """As the server sent it."""
    return snapshot.model_dump_json(exclude_unset=True)


def _write(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


async def _follow(client: AsyncClient, options: WatchOptions, watched: Watched) -> None:
    snapshots = client.follow(
        convention=Convention(options.convention), frame=options.frame, on_wait=watched.fail
    )
    async with aclosing(snapshots):
        async for snapshot in snapshots:
            watched.take(snapshot)


async def _listen(client: AsyncClient, watched: Watched) -> None:
    # What goes wrong, the other stream tells too.
    async with aclosing(client.events(on_wait=lambda *_: None)) as events:
        async for event in events:
            watched.happened(event)


async def _draw(watched: Watched, console: Console, readers: list[asyncio.Task[None]]) -> None:
    with Live(view(watched), console=console, auto_refresh=False) as live:
        while not _has_ended(readers):
            live.update(view(watched), refresh=True)
            await asyncio.sleep(1 / _REDRAWS_PER_S)


async def _tell(watched: Watched, readers: list[asyncio.Task[None]]) -> None:
    due_s = time.monotonic()
    while not _has_ended(readers):
        _write(line(watched))
        due_s += _LINE_S
        await asyncio.sleep(max(due_s - time.monotonic(), 0))


def _has_ended(readers: list[asyncio.Task[None]]) -> bool:
    """Whether there is nothing more to come; raises why."""
    for reader in readers:
        if reader.done():
            reader.result()
            return True
    return False
