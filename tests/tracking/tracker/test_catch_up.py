"""A part that was found is followed to where it is now, beside the tracker."""

import time
from collections.abc import Mapping

import pytest
from patience import within

from snapfit.models.asset import find_asset
from snapfit.models.camera import AZURE_KINECT_720P, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import load_bodies
from snapfit.tracking.finding.catch_up import CatchUp, CatchUpThread, ImmediateCatchUp
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


def test_the_thread_takes_newer_frames_in(follower, frames) -> None:
    catch_up = CatchUpThread(follower)
    catch_up.begin(frames[:4], at(0), are_rough=True)
    for frame in frames[4:]:
        catch_up.add(frame)
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
