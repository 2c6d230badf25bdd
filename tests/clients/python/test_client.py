"""What the client asks, and what it makes of the answers, against a real server."""

from __future__ import annotations

import math
import subprocess
import sys
import time
from collections.abc import Callable
from typing import TypeVar

import pytest
from harness import wait_for
from scripted_pipeline import LOST_PART, PART_NAMES

from snapfit.clients.python import (
    AssemblyFinishedError,
    Client,
    InvalidRequestError,
    NotReachableError,
    NotReadyError,
    PoseSnapshot,
    QrCode,
    Status,
    StepProgress,
    UnknownAnchorError,
    UnknownPartError,
    UnknownStateError,
    UnknownStationError,
)
from snapfit.clients.python.schema import pose_matrix
from snapfit.models.pose import Pose

T = TypeVar("T")


def test_poses_are_typed(client: Client) -> None:
    snapshot = wait_for(lambda: found(client))
    assert [part.part for part in snapshot.parts] == list(PART_NAMES)
    jaw = snapshot.part("jaw")
    assert (jaw.status, jaw.linked_to) == (Status.TRACKED, "base")
    matrix = jaw.matrix()
    assert matrix is not None
    assert tuple(row[3] for row in matrix[:3]) == jaw.position
    assert snapshot.part(LOST_PART).matrix() is None
    with pytest.raises(KeyError, match="no part 'jew'; it has base, jaw"):
        snapshot.part("jew")
    with pytest.raises(ValueError, match="frozen"):
        jaw.confidence = 1.0  # type: ignore[misc]


def patiently(ask: Callable[[], T]) -> T:
    """The answer of a worker that may be held up for longer than the server waits for it."""

    def answer() -> T | None:
        try:
            return ask()
        except NotReadyError:
            return None

    it: T = wait_for(answer)
    return it


def found(client: Client) -> PoseSnapshot | None:
    snapshot = client.poses()
    return snapshot if snapshot.part("jaw").position is not None else None


def test_a_matrix_is_that_of_the_pose() -> None:
    pose = Pose.exp([0.3, -1.2, 0.5, 1.5, 0.2, -0.7])
    x, y, z = pose.translation.tolist()
    qx, qy, qz, qw = pose.quaternion.tolist()
    for ours, row in zip(pose_matrix((x, y, z), (qx, qy, qz, qw)), pose.matrix, strict=True):
        assert ours == pytest.approx(row.tolist(), abs=1e-12)


def test_one_part_in_another_convention_and_time(client: Client) -> None:
    wait_for(lambda: found(client))
    there = client.pose("jaw", convention="unity", at_us=client.time_offset(2).now_us() + 10_000)
    assert (there.convention, there.frame) == ("unity", "camera")
    assert there.at_us is not None
    assert there.at_clamped is not None
    assert there.pose.position is not None
    assert there.pose.position[1] == pytest.approx(-0.02)


def test_what_the_client_has_is_not_sent_again(client: Client) -> None:
    sent: list[int] = []
    hooks = client._transport._http.event_hooks
    client._transport._http.event_hooks = {
        **hooks,
        "response": [lambda response: sent.append(response.status_code)],
    }

    def is_reused() -> bool:
        before = client.poses()
        time.sleep(0.005)
        again = client.poses()
        if sent[-1] != 304:
            return False
        assert again.identity == before.identity
        assert again.parts is before.parts
        assert again.age_us >= before.age_us + 5000
        return True

    assert wait_for(is_reused)
    assert set(sent) == {200, 304}
    client.poses(convention="ros")
    assert sent[-1] == 200


def test_the_next_snapshot_is_waited_for(client: Client) -> None:
    first = client.poses()
    # One of a worker that is held up becomes stale, which is news too.
    later = wait_for(lambda: (it := client.next_poses(first, timeout_s=5)) and not it.stale and it)
    assert later.boot_id == first.boot_id
    assert later.seq > first.seq
    wait_for(lambda: client.next_assembly(client.assembly(), timeout_s=0.05) is None)


def test_assembly_and_steps_and_what_an_operator_says(client: Client) -> None:
    patiently(lambda: client.set_state("free"))
    assert client.step().step.step == "mount-jaw"
    assert client.step("screw-bolt").step.progress is StepProgress.LATER
    result = client.set_state("jaw-mounted")
    assert (result.changed, result.state) == (True, "jaw-mounted")
    assembly = client.assembly()
    assert (assembly.decided_by, assembly.finished_steps) == ("operator", ("mount-jaw",))
    ghost = client.steps().steps[0].ghost
    assert ghost is not None
    assert (ghost.part, ghost.parent) == ("jaw", "base")
    client.set_state("assembled")
    with pytest.raises(AssemblyFinishedError):
        client.step()
    assert client.reset().state == "free"
    wait_for(lambda: found(client))
    assert client.reinitialise("jaw").done == ("jaw is looked for again",)
    wait_for(lambda: found(client))


def test_anchors(client: Client) -> None:
    board = QrCode(text="bench", size_m=0.2)
    put = client.put_anchor("headset", [0.1, 0.9, 0.6], [0, 0, 0, 1], board=board, ttl_s=60)
    assert (put.frame, put.aligned, put.board) == ("anchor:headset", False, board)
    assert client.anchor("headset", convention="unity").convention == "unity"
    assert [each.anchor for each in client.anchors()] == ["headset"]
    client.delete_anchor("headset")
    with pytest.raises(UnknownAnchorError):
        client.anchor("headset")
    with pytest.raises(ValueError, match="position"):
        client.put_anchor("headset", [0.1], [0, 0, 0, 1])


def test_pictures_models_and_assets(client: Client) -> None:
    picture = patiently(client.frame_jpeg)
    assert picture.jpeg.startswith(b"\xff\xd8")
    assert picture.captured_at_us > 1e15
    assert patiently(client.overlay_jpeg).jpeg != picture.jpeg
    assert [each.asset for each in client.assets()] == ["scripted-asset"]
    asset = client.asset()
    assert asset.parts[1].part == "jaw"
    model = client.part_model("jaw")
    assert model.startswith(b"glTF")
    assert len(model) == asset.parts[1].mesh_bytes


@pytest.mark.parametrize("path", ["https://example.com/jaw.mp4", "//example.com/x", "/healthz"])
def test_the_key_goes_to_nobody_else(client: Client, path: str) -> None:
    with pytest.raises(ValueError, match="not on this server"):
        client.media(path)


def test_the_servers_clock(client: Client) -> None:
    offset = client.time_offset()
    assert 0 < offset.round_trip_us < 1e6
    assert abs(offset.offset_us) < 1e6
    before_us, snapshot, after_us = offset.now_us(), client.poses(), offset.now_us()
    room_us = offset.round_trip_us / 2 + 1000
    asked_at_us = snapshot.captured_at_us + snapshot.age_us
    assert before_us - room_us <= asked_at_us <= after_us + room_us


def test_the_server_itself(client: Client) -> None:
    assert client.health().status == "ok"
    assert patiently(client.ready).status == "ready"
    assert client.info().station == "bench-1"
    (station,) = client.stations()
    assert station.facts is not None
    assert math.isclose(station.facts.frame_rate_hz, 30)


def test_problems_are_errors_of_their_kind(client: Client) -> None:
    with pytest.raises(UnknownPartError, match="it has base, jaw") as unknown:
        client.pose("jew")
    assert unknown.value.names == PART_NAMES
    assert (unknown.value.status, unknown.value.kind) == (404, "unknown-part")
    with pytest.raises(UnknownStateError) as state:
        client.set_state("glued")
    assert state.value.names == ("free", "jaw-mounted", "assembled")
    with pytest.raises(InvalidRequestError, match="convention"):
        client.poses(convention="unreal")  # type: ignore[arg-type]
    nowhere = client.at("bench-9")
    for ask in (nowhere.poses, nowhere.info, nowhere.reset, nowhere.frame_jpeg):
        with pytest.raises(UnknownStationError) as station:
            ask()
        assert station.value.names == ("bench-1",)
    assert client.at("bench-1").poses().station == "bench-1"


def test_a_server_that_is_not_there() -> None:
    with (
        Client("http://127.0.0.1:9", timeout_s=2) as client,
        pytest.raises(NotReachableError, match=r"http://127\.0\.0\.1:9 does not answer"),
    ):
        client.poses()


@pytest.mark.parametrize("url", ["127.0.0.1:8000", "ftp://bench", "http://", "http://a:b", ""])
def test_what_is_no_address_is_refused(url: str) -> None:
    with pytest.raises(ValueError, match="is no address"):
        Client(url)


def test_it_imports_nothing_of_the_other_rooms() -> None:
    code = (
        "import sys; import snapfit.clients.python; "
        "print([m for m in sys.modules if m.startswith('snapfit.') and '.clients' not in m])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
