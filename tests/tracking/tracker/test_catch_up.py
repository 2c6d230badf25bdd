"""A part that was found is followed to where it is now, beside the tracker."""

import threading
import time
from collections.abc import Mapping
from dataclasses import replace

import pytest
from patience import within

from snapfit.models.asset import find_asset
from snapfit.models.camera import AZURE_KINECT_720P, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import load_bodies
from snapfit.tracking.finding.catch_up import CatchUp, CatchUpThread, ImmediateCatchUp
from snapfit.tracking.result import PartEstimate, Status, TrackingResult
from snapfit.tracking.tracker import Tracker

CAMERA = RgbdCamera(AZURE_KINECT_720P, AZURE_KINECT_720P)
TURN = Pose.exp([0.5, 0.6, -0.3, 0, 0, 0])
STEP_M = 0.004


def at(number: int) -> dict[str, Pose]:
    return {"jaw": Pose.from_translation(-0.12 + STEP_M * number, 0.0, 0.65) @ TURN}


@pytest.fixture(scope="module")
def follower() -> Tracker:
    return Tracker(load_bodies(find_asset("hobby-corner-clamp").tracked_parts[1:2]), CAMERA)


@pytest.fixture(scope="module")
def frames(clamp, draw):
    return [draw(clamp[1:2], at(number), name=str(number)) for number in range(12)]


def taken(catch_up: CatchUp) -> Mapping[str, Pose]:
    until_s = time.monotonic() + within(60)
    while (poses := catch_up.take()) is None:
        assert time.monotonic() < until_s
        time.sleep(0.01)
    return poses


@pytest.mark.parametrize("kind", [ImmediateCatchUp, CatchUpThread])
def test_a_moving_part_is_followed_to_the_last_frame(kind, follower, frames) -> None:
    catch_up = kind(follower)
    assert not catch_up.is_busy
    assert catch_up.take() is None
    catch_up.begin(frames, at(0), are_rough=True)
    assert catch_up.is_busy
    assert taken(catch_up)["jaw"].distance_to(at(11)["jaw"]) < 0.002
    assert not catch_up.is_busy
    assert catch_up.take() is None
    catch_up.close()


def test_the_thread_takes_newer_frames_in(follower, frames, monkeypatch) -> None:
    added, track = threading.Event(), follower.track

    def track_once_added(frame):
        assert added.wait(within(60))
        return track(frame)

    monkeypatch.setattr(follower, "track", track_once_added)
    catch_up = CatchUpThread(follower)
    catch_up.begin(frames[:4], at(0), are_rough=True)
    for frame in frames[4:]:
        catch_up.add(frame)
    added.set()
    assert taken(catch_up)["jaw"].distance_to(at(11)["jaw"]) < 0.002
    catch_up.close()


def test_a_part_that_is_not_there_is_left_out(follower, frames) -> None:
    catch_up = ImmediateCatchUp(follower)
    wall = Pose.from_translation(0.2, 0.1, 0.5) @ TURN
    catch_up.begin(frames[:3], {"jaw": wall}, are_rough=True)
    assert catch_up.take() == {}


def test_a_part_behind_the_camera_is_left_out_and_told(follower, frames, caplog) -> None:
    catch_up = CatchUpThread(follower)
    behind = Pose.from_translation(0, 0, -0.5)
    catch_up.begin(frames[:1], {"jaw": behind}, are_rough=False)
    assert taken(catch_up) == {}
    assert "not in front of the camera" in caplog.text
    catch_up.begin(frames, at(0), are_rough=False)
    assert "jaw" in taken(catch_up)
    catch_up.close()


def test_a_bug_while_following_costs_one_start(follower, frames, monkeypatch, caplog) -> None:
    catch_up = CatchUpThread(follower)
    with monkeypatch.context() as patch:
        patch.setattr(follower, "track", lambda _frame: 1 // 0)
        catch_up.begin(frames[:2], at(0), are_rough=False)
        assert taken(catch_up) == {}
    assert "ZeroDivisionError" in caplog.text
    catch_up.begin(frames[:2], at(0), are_rough=False)
    assert "jaw" in taken(catch_up)
    catch_up.close()


def test_closing_does_not_wait_for_all_that_is_left(follower, frames) -> None:
    catch_up = CatchUpThread(follower)
    catch_up.begin(frames * 20, at(0), are_rough=True)
    catch_up.close()
    assert catch_up.take() is None or not catch_up.is_busy


class Slow:
    """Follows nothing until it may, and notes the frames that it is shown."""

    names = ("jaw",)

    def __init__(self) -> None:
        self.may = threading.Event()
        self.shown: list[str] = []

    def stop(self, name: str) -> None:
        assert name == "jaw"

    def start(self, frame, starts, *, are_rough: bool) -> None:
        assert (frame.name, list(starts), are_rough) == ("0", ["jaw"], False)

    def track(self, frame) -> TrackingResult:
        assert self.may.wait(within(60))
        self.shown.append(frame.name)
        number = min(int(frame.name), 11)
        jaw = PartEstimate("jaw", Status.TRACKED, 0.9, at(number)["jaw"])
        return TrackingResult(frame.name, 0, (jaw,), 1.0)


def test_one_that_is_too_slow_leaves_frames_out_and_holds_few(frames) -> None:
    slow = Slow()
    catch_up = CatchUpThread(slow)
    catch_up.begin(frames[:1], at(0), are_rough=False)
    for number in range(1, 500):
        catch_up.add(replace(frames[0], name=str(number)))
        assert len(catch_up._frames) <= 61
    slow.may.set()
    assert "jaw" in taken(catch_up)
    assert (slow.shown[0], slow.shown[-1]) == ("0", "499")
    assert 10 <= len(slow.shown) <= 61
    assert slow.shown == sorted(slow.shown, key=int)
    catch_up.close()
