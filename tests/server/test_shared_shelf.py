"""What a replica takes from Redis; several replicas are in test_fleet_shared.py."""

from __future__ import annotations

from snapfit.server.anchor_record import ViewRecord, anchor_record
from snapfit.server.boards import ArucoMarker
from snapfit.server.fleet.keys import StationKeys
from snapfit.server.fleet.shared_shelf import SharedShelf
from snapfit.server.rigid import Rigid

KEYS = StationKeys("bench-1")
BOARD = ArucoMarker(kind="aruco", id=3, size_m=0.1)
HERE = Rigid((0.0, 0.0, 0.5), (0.0, 0.0, 0.0, 1.0))


class SlowRedis:
    """Holds one anchor and how its board was seen; notes what is known whenever it is asked."""

    def __init__(self, shelf: SharedShelf) -> None:
        anchor = anchor_record("a", BOARD, HERE, now_us=1, ttl_s=60)
        view = ViewRecord(board=BOARD, poses=anchor.worlds, error_px=0.1, seen_at_us=1)
        self._held = {
            KEYS.anchors: {b"#": b"1", b"a": anchor.model_dump_json().encode()},
            KEYS.views: {BOARD.model_dump_json().encode(): view.model_dump_json().encode()},
        }
        self._shelf = shelf
        self.known: list[tuple[bool, bool]] = []

    def hgetall(self, key: str) -> dict[bytes, bytes]:
        self.known.append((bool(self._shelf.records), bool(self._shelf.views)))
        return self._held[key]


def test_no_anchor_is_known_before_it_is_known_how_its_board_was_seen() -> None:
    shelf = SharedShelf("redis://127.0.0.1:1/0", KEYS, lambda: None)
    redis = SlowRedis(shelf)
    shelf.catch_up(redis)  # type: ignore[arg-type]
    assert redis.known == [(False, False)] * 2
    assert list(shelf.records) == ["a"]
    assert list(shelf.views) == [BOARD]
    shelf.close()
