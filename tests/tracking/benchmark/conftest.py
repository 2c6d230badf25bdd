"""A small dataset, and a tracker that follows a script instead of images."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from snapfit.models.asset import Part
from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.manifest import SymmetryTable
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.models.sequence import BodyRecord
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.tracking.assembly.estimate import AssemblyEstimate, Misassembly, MisassemblyKind
from snapfit.tracking.benchmark import contest, roster
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import PartEstimate, Status, TrackingResult

SMALL = PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5)
N_FRAMES = 6
COVARIANCE = np.diag([0.01, 0.01, 0.01, 0.001, 0.001, 0.001]) ** 2

Script = Callable[[int, str, Pose], Pose | None]


def true_pose(number: int, part: str = "box") -> Pose:
    """Where a part is in a frame."""
    return Pose.from_translation(0.001 * number, 0.05 * (part == "pin"), 0.5)


def write_sequence(folder: Path) -> Path:
    """A sequence of a box and a symmetric pin; the assembly state changes in frame 3."""
    folder.mkdir(parents=True)
    trimesh.creation.box((0.04, 0.05, 0.06)).export(folder / "box.ply")
    trimesh.creation.cylinder(0.01, 0.06, sections=12).export(folder / "pin.ply")
    axis = SymmetryTable.model_validate({"axis": {"direction": [0, 0, 1]}})
    bodies = {"box": BodyRecord(mesh="box.ply"), "pin": BodyRecord(mesh="pin.ply", symmetry=axis)}
    camera = RgbdCamera(SMALL, SMALL)
    with SequenceWriter(folder, camera, bodies=bodies, note="bench, seed 3") as writer:
        for i in range(N_FRAMES):
            poses = {name: true_pose(i, name) for name in bodies}
            state = "apart" if i < 3 else "joined"
            truth = GroundTruth(f"{i:03d}", poses, {"box": 1.0}, state)
            color = np.full((48, 64, 3), 90, np.uint8)
            writer.write(truth.frame, color, np.full((48, 64), 500, np.uint16), truth)
    return folder


@pytest.fixture
def dataset(tmp_path: Path) -> Path:
    """Two assets, the first under three conditions."""
    folder = tmp_path / "data"
    for asset, condition in (
        ("clamp", "all"),
        ("clamp", "blur"),
        ("clamp", "normal"),
        ("vise", "normal"),
    ):
        write_sequence(folder / asset / "test" / condition)
    return folder


class ScriptedTracker:
    """Answers what a script says of the true pose; reports the state a frame late."""

    def __init__(self, script: Script, parts: Sequence[Part], method: str) -> None:
        self.method = method
        self.told: list[tuple[str, int]] = []
        self.tracked: list[str] = []
        self._script = script
        self._names = [part.name for part in parts]
        self.started: Mapping[str, Pose] = {}

    def start(self, _frame: Frame, camera_from_body: Mapping[str, Pose]) -> None:
        self.started = camera_from_body

    def set_state(self, name: str) -> None:
        self.told.append((name, len(self.tracked)))

    def track(self, frame: Frame) -> TrackingResult:
        self.tracked.append(frame.name)
        number = int(frame.name)
        estimates = []
        for name in self._names:
            pose = self._script(number, name, true_pose(number, name))
            status = Status.TRACKED if pose else Status.LOST
            estimates.append(PartEstimate(name, status, 0.9, pose, COVARIANCE))
        state = "apart" if number < 4 else "joined"
        result = TrackingResult(frame.name, frame.captured_at_ns, tuple(estimates), 1.5, state)
        # The pin sits wrong in frames 1, 2 and 5.
        wrong = Misassembly("pin", "box", MisassemblyKind.WRONG_PLACE, number, 0.1, 0.0)
        found = (wrong,) if number in (1, 2, 5) else ()
        return replace(result, assembly=AssemblyEstimate(state, 1.0, None, (), (), found))


@dataclass(frozen=True)
class Entry:
    """A method in the table of methods."""

    parameters: int = 0
    needs_true_state: bool = False
    ablation_of: str = ""
    is_cold: bool = False
    summary: str = ""


@pytest.fixture
def methods(monkeypatch: pytest.MonkeyPatch) -> dict[str, Entry]:
    """The table of methods for the benchmark: two, one told the states, one an ablation."""
    table = {
        "icg": Entry(),
        "graph": Entry(1, summary="follows the graph"),
        "told": Entry(2, needs_true_state=True),
        "graph-rigid": Entry(3, ablation_of="graph"),
        "cold": Entry(4, is_cold=True),
    }
    monkeypatch.setattr(roster, "METHODS", table)
    return table


@pytest.fixture
def scripted(monkeypatch: pytest.MonkeyPatch) -> Callable[[Script], list[ScriptedTracker]]:
    """Puts scripted trackers in the place of real ones; returns the list of those made."""

    def use(script: Script) -> list[ScriptedTracker]:
        made: list[ScriptedTracker] = []

        def create(method: str, parts: Sequence[Part], *_: Any, **__: Any) -> ScriptedTracker:
            made.append(ScriptedTracker(script, parts, method))
            return made[-1]

        monkeypatch.setattr(contest, "create_tracker", create)
        return made

    return use


def two_mm_beside(number: int, part: str, truth: Pose) -> Pose | None:
    """2 mm beside the truth; the box is lost in frame 5."""
    if part == "box" and number == 5:
        return None
    return Pose.from_translation(0.002, 0, 0) @ truth


@pytest.fixture
def beside() -> Script:
    """The script `two_mm_beside`."""
    return two_mm_beside
