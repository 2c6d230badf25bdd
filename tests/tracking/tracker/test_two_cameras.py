"""A simulated bench with two cameras: the hand comes before one of them, the other goes on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest

from snapfit.models.asset import Asset, find_asset
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.symmetry import distance_modulo_symmetry
from snapfit.models.workbench.film import Film
from snapfit.models.workbench.scene import looking_at
from snapfit.models.workbench.split import FRAME_RATE_HZ, Condition
from snapfit.tracking.camera_view import RigCamera
from snapfit.tracking.frame import Frame
from snapfit.tracking.methods import create_tracker

N_FRAMES, SEED, SCALE = 400, 20, 0.5
FIRST, LAST = 62, 102
OPPOSITE = looking_at((-0.1, 0.5, 0.35), (0.0, -0.03, 0.04))
HELD = "jaw"


@dataclass(frozen=True, eq=False)
class Bench:
    """Frames of two cameras, and what is true in them."""

    asset: Asset
    camera: RgbdCamera
    placed: RigCamera
    frames: Sequence[tuple[Frame, Frame]]
    truth: Sequence[dict[str, Pose]]
    visibility: np.ndarray  # (frames, cameras) of the held part


@pytest.fixture(scope="module")
def bench() -> Bench:
    """A jaw is carried to its place; meanwhile the hand hides it from the first camera."""
    asset = find_asset("hobby-corner-clamp")
    film = Film(asset, N_FRAMES, SEED, SCALE)
    opposite = film.beside(OPPOSITE)
    relative = OPPOSITE @ film.scene.camera_from_world.inverse()
    frames, truth, visibility = [], [], []
    for index in range(FIRST, LAST):
        views = [each.frame(index, Condition.HAND) for each in (film, opposite)]
        at_ns = round(index / FRAME_RATE_HZ * 1e9)
        frames.append(tuple(Frame(str(index), at_ns, view.color, view.depth) for view in views))
        truth.append({name: s.camera_from_body for name, s in views[0].sightings.items()})
        visibility.append([view.sightings[HELD].visibility for view in views])
    placed = RigCamera(opposite.camera, relative)
    return Bench(asset, film.camera, placed, frames, truth, np.array(visibility))


def errors(bench: Bench, method: str, n_cameras: int) -> np.ndarray:
    """(frames, 2) of the held part: mm and degrees, symmetry taken out."""
    rig = [bench.placed] * (n_cameras - 1)
    parts = bench.asset.tracked_parts
    tracker = create_tracker(method, parts, bench.camera, asset=bench.asset, rig=rig)
    first, *others = bench.frames[0][:n_cameras]
    tracker.start(first, bench.truth[0], *others)
    symmetry = next(part.symmetry for part in parts if part.name == HELD)
    found = []
    for frames, truth in zip(bench.frames, bench.truth, strict=True):
        estimates = tracker.track(*frames[:n_cameras]).parts
        pose = next(each.camera_from_body for each in estimates if each.part == HELD)
        distance_m, angle_rad = np.inf, np.inf
        if pose is not None:
            distance_m, angle_rad = distance_modulo_symmetry(pose, truth[HELD], symmetry)
        found.append((distance_m * 1e3, np.degrees(angle_rad)))
    return np.array(found)


def test_the_hand_hides_the_part_from_one_camera_alone(bench: Bench) -> None:
    first, second = bench.visibility.T
    hidden = first < 0.02
    assert hidden.sum() >= 15
    assert (second[hidden] > 0.8).all()
    # Hidden, the part goes on.
    start, end = np.flatnonzero(hidden)[[0, -1]]
    assert bench.truth[start][HELD].distance_to(bench.truth[end][HELD]) > 0.01


@pytest.mark.parametrize("method", [pytest.param("icg", marks=pytest.mark.slow), "gbot"])
def test_two_cameras_keep_the_part_that_one_loses(bench: Bench, method: str) -> None:
    alone, both = (errors(bench, method, n_cameras) for n_cameras in (1, 2))
    distance_mm, angle_deg = np.percentile(both, 95, axis=0)
    assert distance_mm < 3
    assert angle_deg < 3
    assert np.percentile(alone[:, 0], 95) > 5 * distance_mm
    assert np.percentile(alone[:, 0], 95) > 8
