"""Hidden parts go with the hand that was seen to hold them, and only with that."""

import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.camera import AZURE_KINECT_720P, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body
from snapfit.tracking.frame import Frame
from snapfit.tracking.recovery.carried import CarriedParts

CAMERA = RgbdCamera(AZURE_KINECT_720P, AZURE_KINECT_720P)
HOME = Pose.from_translation(0.0, 0.0, 0.6)
HAND_MM = 520


@pytest.fixture(scope="module")
def carried() -> CarriedParts:
    part = find_asset("hobby-corner-clamp").tracked_parts[1]
    return CarriedParts([Body(part.name, part.mesh, None)], CAMERA)  # type: ignore[arg-type]


def frame_of(shift_px: tuple[int, int], nearer_mm: int = 0) -> Frame:
    """A textured hand that covers everything, shifted in the image."""
    rng = np.random.default_rng(3)
    small = rng.integers(0, 255, (110, 180, 3)).astype(np.uint8)
    large = np.repeat(np.repeat(small, 8, axis=0), 8, axis=1)
    u, v = 40 - shift_px[0], 40 - shift_px[1]
    color = np.ascontiguousarray(large[v : v + 720, u : u + 1280])
    return Frame("0", 0, color, np.full((720, 1280), HAND_MM - nearer_mm, dtype=np.uint16))


def seen_moving(carried: CarriedParts, step_m: float) -> Pose:
    pose = HOME
    for i in range(12):
        pose = Pose.from_translation(i * step_m, 0, 0) @ HOME
        carried.follow(frame_of((0, 0)), {0: pose}, {})
    return pose


def test_a_moving_part_goes_with_the_hand(carried) -> None:
    pose = seen_moving(carried, 0.003)
    assert carried.follow(frame_of((0, 0)), {}, {0: pose}) == {}
    moved = carried.follow(frame_of((12, -8), nearer_mm=4), {}, {0: pose})[0]
    depth_m, camera = HAND_MM / 1000, CAMERA.color
    wanted = (12 * depth_m / camera.fx, -8 * depth_m / camera.fy, -0.004)
    assert np.allclose(moved.translation - pose.translation, wanted, atol=0.0012)
    assert moved.angle_to(pose) < 1e-9


def test_a_part_that_lay_still_stays(carried) -> None:
    for _ in range(30):
        carried.follow(frame_of((0, 0)), {0: HOME}, {})
    carried.follow(frame_of((0, 0)), {}, {0: HOME})
    assert carried.follow(frame_of((12, -8)), {}, {0: HOME}) == {}


def test_at_the_border_and_without_a_match_nothing_is_claimed(carried) -> None:
    pose = seen_moving(carried, 0.003)
    carried.follow(frame_of((0, 0)), {}, {0: pose})
    rng = np.random.default_rng(9)
    noise = rng.integers(0, 255, (720, 1280, 3)).astype(np.uint8)
    other = Frame("0", 0, noise, np.full((720, 1280), HAND_MM, dtype=np.uint16))
    assert carried.follow(other, {}, {0: pose}) == {}
    seen_moving(carried, 0.003)
    outside = Pose.from_translation(1.0, 0, 0.6)
    carried.follow(frame_of((0, 0)), {}, {0: outside})
    assert carried.follow(frame_of((4, 0)), {}, {0: outside}) == {}
