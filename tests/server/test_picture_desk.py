"""A picture that is there is given to a client, and no client is kept waiting for none."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from types import SimpleNamespace
from typing import cast

import pytest

from snapfit.server import picture_desk
from snapfit.server.picture_desk import PictureDesk
from snapfit.server.picture_message import PictureMessage, pack_picture
from snapfit.server.pose_store import Picture, PoseStore
from snapfit.server.problems import ProblemError
from snapfit.server.routes.pictures import _frames
from snapfit.server.station import Station


class Desk:
    """A desk whose time stands still."""

    def __init__(self, store: PoseStore) -> None:
        self.mailbox = store.pictures[Picture.FRAME]
        self.is_up = True
        self.now_s = 1000.0
        self._desk = PictureDesk("bench", store, lambda: self.is_up)

    def monotonic(self) -> float:
        return self.now_s

    async def begin(self, generation: int) -> asyncio.Task[PictureMessage]:
        """Ask for a picture; it is waited for now."""
        picture = asyncio.create_task(self._desk.picture(Picture.FRAME, generation))
        await asyncio.sleep(0)
        return picture


@pytest.fixture
def desk(monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    store = PoseStore.create()
    it = Desk(store)
    monkeypatch.setattr(picture_desk, "time", it)
    yield it
    store.close()


def test_a_picture_that_came_while_the_desk_was_held_up_is_given(desk: Desk) -> None:
    async def held_up() -> PictureMessage:
        asked = await desk.begin(7)
        desk.mailbox.write(pack_picture(7, 123, b"jpeg"))
        desk.now_s += 10
        return await asked

    assert asyncio.run(held_up()).captured_at_us == 123


@pytest.mark.parametrize("is_up", [True, False])
def test_nobody_waits_longer_than_there_is_hope(desk: Desk, is_up: bool) -> None:
    async def too_late() -> None:
        desk.mailbox.write(pack_picture(6, 123, b"jpeg"))
        asked = await desk.begin(7)
        desk.is_up = is_up
        desk.now_s += 10 * is_up
        with pytest.raises(ProblemError, match="delivered no picture"):
            await asked

    asyncio.run(too_late())


def test_a_film_that_is_to_end_waits_for_no_other_picture() -> None:
    watch = SimpleNamespace(is_ending=False)

    async def change(_limit_s: float) -> None:
        watch.is_ending = True

    async def picture(_kind: Picture) -> PictureMessage:
        raise AssertionError("never asked")

    watch.change = change
    station = cast("Station", SimpleNamespace(watch=watch, picture=picture))

    async def shown() -> list[bytes]:
        first = PictureMessage(1, 123, b"jpeg")
        return [part async for part in _frames(station, Picture.FRAME, first)]

    assert len(asyncio.run(shown())) == 1
