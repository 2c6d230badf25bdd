"""Plays drawn frames of a bench to a tracker that finds the parts by itself."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from snapfit.models.asset import Part, find_asset
from snapfit.models.camera import AZURE_KINECT_720P, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.symmetry import distance_modulo_symmetry
from snapfit.tracking.finding.catch_up import ImmediateCatchUp
from snapfit.tracking.finding.create import create_finder
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.lookout import DelayedLookout
from snapfit.tracking.finding.self_starting import SelfStartingTracker
from snapfit.tracking.frame import Frame
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.result import PartEstimate, Status, TrackingResult
from snapfit.tracking.tracker import Tracker

CAMERA = RgbdCamera(AZURE_KINECT_720P, AZURE_KINECT_720P)
# The bench in the colour camera's frame: 45 degrees below it, 0.42 m away.
NORMAL = np.array([0.0, -1.0, -1.0]) / np.sqrt(2)
OFFSET_M = 0.42

ASSET = find_asset("hobby-corner-clamp")
PARTS = ASSET.tracked_parts
DELAY_FRAMES = {"stand-in": 3, "geometric": 30}


@dataclass(frozen=True, eq=False)
class Shot:
    """A frame that is shown for a while, and where the parts are in it."""

    frame: Frame
    poses: Mapping[str, Pose]
    n_frames: int


@dataclass(frozen=True, eq=False)
class Played:
    """What a tracker said of a frame."""

    result: TrackingResult

    def part(self, name: str) -> PartEstimate:
        return next(each for each in self.result.parts if each.part == name)

    def are_right(self, poses: Mapping[str, Pose]) -> bool:
        """Whether these parts are tracked, and within 3 mm and 3 degrees."""
        return all(self._is_right(name, pose) for name, pose in poses.items())

    def _is_right(self, name: str, pose: Pose) -> bool:
        said = self.part(name)
        if said.status is not Status.TRACKED or said.camera_from_body is None:
            return False
        symmetry = next(part.symmetry for part in PARTS if part.name == name)
        off_m, off_rad = distance_modulo_symmetry(said.camera_from_body, pose, symmetry)
        return bool(off_m < 0.003 and np.degrees(off_rad) < 3 and said.confidence > 0.5)


class StandIn:
    """A finder that knows the truth of each frame, and says it 4 mm and 3 degrees off."""

    def __init__(self, truth: Mapping[str, Mapping[str, Pose]]) -> None:
        self.names = tuple(part.name for part in PARTS)
        self._truth, self._rng = truth, np.random.default_rng(1)

    def find(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> list[Hypothesis]:
        del known
        found = []
        for name, pose in self._truth[frame.name].items():
            off = self._rng.normal(0, [0.05] * 3 + [0.004] * 3)
            if name in wanted:
                found.append(Hypothesis(name, pose.perturbed(off), 0.9))
        return found


def play(method: str, detector: str, shots: Sequence[Shot]) -> list[Played]:
    """What the tracker says of each frame."""
    sequence = [shot for shot in shots for _ in range(shot.n_frames)]
    frames = [replace(shot.frame, name=str(i)) for i, shot in enumerate(sequence)]
    tracker = create_tracker(method, PARTS, CAMERA, asset=ASSET)
    assert isinstance(tracker, Tracker)
    if detector == "stand-in":
        finder = StandIn({str(i): shot.poses for i, shot in enumerate(sequence)})
    else:
        finder = create_finder(detector, PARTS, tracker.bodies, CAMERA, ASSET)
    finding = SelfStartingTracker(
        tracker,
        PARTS,
        DelayedLookout(finder, DELAY_FRAMES[detector]),
        catch_up=ImmediateCatchUp(Tracker(tracker.bodies, CAMERA)),
    )
    return [Played(finding.track(frame)) for frame in frames]


def on_bench(part: Part, rotation: Sequence[float], x_m: float, y_m: float) -> Pose:
    """`camera_from_body` of a part that touches the bench, above the point on the ray (x, y, 1)."""
    turn = Pose.exp([*rotation, 0, 0, 0])
    ray = np.array([x_m, y_m, 0.58])
    ground = ray * (-OFFSET_M / (NORMAL @ ray))
    center = turn.transform(part.mesh.center_m)
    lowest = (turn.transform(part.mesh.vertices) - center) @ NORMAL
    translation = ground - center - lowest.min() * NORMAL
    return Pose.from_rotation_translation(turn.rotation, translation)
