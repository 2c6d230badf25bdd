"""How soon all parts are right: which trials there are, what counts, and what is told."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from snapfit.models.asset import Part
from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth, Recording
from snapfit.models.sequence import BodyRecord
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.tracking.benchmark import recovery
from snapfit.tracking.benchmark.covered import Cover, covered
from snapfit.tracking.benchmark.recovery import (
    Recovered,
    TrialKind,
    check_can_recover,
    run_trials,
    trials,
)
from snapfit.tracking.benchmark.recovery_report import recovery_json, recovery_markdown
from snapfit.tracking.benchmark.rightness import Rightness
from snapfit.tracking.benchmark.sequences import SequenceFolder, open_sequence
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import PartEstimate, Status, TrackingResult

CAMERA = RgbdCamera(*[PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5)] * 2)
HERE, THERE = Pose.from_translation(0, 0, 0.5), Pose.from_translation(0.1, 0, 0.5)
N_FRAMES = 12


def pose_in(number: int) -> Pose:
    return Pose.from_translation(0.01 * number, 0, 0.5)


@pytest.fixture
def folder(tmp_path: Path) -> SequenceFolder:
    """12 frames of a moving box, one a second."""
    take = tmp_path / "take"
    take.mkdir()
    trimesh.creation.box((0.04, 0.05, 0.06)).export(take / "box.ply")
    bodies = {"box": BodyRecord(mesh="box.ply")}
    with SequenceWriter(take, CAMERA, bodies=bodies, frame_rate_hz=1.0) as writer:
        for i in range(N_FRAMES):
            color = np.full((48, 64, 3), 90, np.uint8)
            depth = np.full((48, 64), 500, np.uint16)
            writer.write(f"{i:03d}", color, depth, GroundTruth(f"{i:03d}", {"box": pose_in(i)}))
    return SequenceFolder("vise", "normal", take)


class SlowTracker:
    """Right in the third frame that shows anything; where it is told the pose, until it is dark."""

    names = ("box",)
    camera = CAMERA

    def __init__(self, wait: int = 2) -> None:
        self.wait, self.seen = wait, 0
        self.started: Mapping[str, Pose] = {}
        self.dark: list[str] = []

    def start(self, _frame: Frame, camera_from_body: Mapping[str, Pose]) -> None:
        self.started, self.seen = camera_from_body, self.wait

    def track(self, frame: Frame) -> TrackingResult:
        assert frame.depth is not None
        if not (frame.depth == 500).all():
            self.dark.append(frame.name)
            self.seen = -1
        self.seen += 1
        pose = pose_in(int(frame.name)) if self.seen > self.wait else None
        status = Status.TRACKED if pose else Status.LOST
        parts = (PartEstimate("box", status, 1.0, pose),)
        return TrackingResult(frame.name, frame.captured_at_ns, parts, 1.0)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[SlowTracker]:
    trackers: list[SlowTracker] = []

    def create(method: str, *_: Any, frame_rate_hz: float, **__: Any) -> SlowTracker:
        assert frame_rate_hz == 1.0
        if method == "gbot+reinit-geometric":
            raise TrackingError("no Open3D")
        trackers.append(SlowTracker(99 if method == "gbot" else 2))
        return trackers[-1]

    monkeypatch.setattr(recovery, "create_tracker", create)
    return trackers


def box(name: str, size_m: tuple[float, float, float] = (0.04, 0.05, 0.06)) -> Part:
    shape = trimesh.creation.box(size_m)
    return Part(name=name, mesh=Mesh(shape.vertices, shape.faces))


def test_trials_begin_every_hundred_frames_and_end_in_time() -> None:
    found = trials(400, 30.0)
    cold = [each.first for each in found if each.kind is TrialKind.COLD]
    hidden = [each for each in found if each.kind is TrialKind.COVERED]
    assert cold == [0, 100, 200]
    assert [each.first for each in hidden] == [0, 100]
    assert hidden[1].covered_frames == range(130, 190)
    assert (hidden[1].judged_from, hidden[1].end) == (190, 340)
    assert [each.cover for each in hidden] == [Cover.LENS, Cover.HAND]
    assert trials(149, 30.0) == ()
    assert max(each.end for each in trials(900, 30.0)) <= 900


def test_the_time_is_counted_from_the_first_frame_that_shows_anything(
    folder: SequenceFolder, made: list[SlowTracker]
) -> None:
    results, problems = run_trials(folder, open_sequence(folder), ["gbot+reinit", "gbot"])
    assert not problems
    cold, hidden, alone = results
    assert (cold.kind, cold.method, cold.frames) == (TrialKind.COLD, "gbot+reinit", 2)
    assert made[0].started == {}
    assert (hidden.kind, hidden.method, hidden.frames) == (TrialKind.COVERED, "gbot+reinit", 2)
    assert made[1].started["box"].distance_to(pose_in(0)) == 0
    assert made[1].dark == made[2].dark == ["001", "002"]
    # The one without a detector has no cold start, and does not come back.
    assert (alone.kind, alone.method, alone.frames) == (TrialKind.COVERED, "gbot", None)
    assert alone.wrong == ("box",)


def test_frames_in_which_no_part_is_seen_tell_nothing(
    folder: SequenceFolder, made: list[SlowTracker]
) -> None:
    recording = open_sequence(folder)
    truth = {
        name: replace(each, visibility={"box": 0.1 if int(name) < 2 else 0.9})
        for name, each in recording.truth.items()
    }
    results, _ = run_trials(folder, replace(recording, truth=truth), ["gbot+reinit"])
    # It is right in the third frame, the first one that shows the box.
    assert (results[0].kind, results[0].frames) == (TrialKind.COLD, 0)
    assert made[0].seen == 3
    hidden = {name: replace(each, visibility={"box": 0.1}) for name, each in truth.items()}
    assert run_trials(folder, replace(recording, truth=hidden), ["gbot+reinit"]) == ([], {})


def test_a_method_that_cannot_be_made_does_not_stop_the_others(
    folder: SequenceFolder, made: list[SlowTracker]
) -> None:
    methods = ["gbot+reinit-geometric", "gbot+reinit"]
    results, problems = run_trials(folder, open_sequence(folder), methods)
    assert {each.method for each in results} == {"gbot+reinit"}
    assert str(problems["gbot+reinit-geometric"]) == "no Open3D"


def test_a_short_sequence_is_told(folder: SequenceFolder) -> None:
    recording: Recording = open_sequence(folder, 4)
    with pytest.raises(TrackingError, match="shorter than 5 s"):
        run_trials(folder, recording, ["gbot"])


@pytest.mark.parametrize(
    ("method", "problem"),
    [
        ("mbicg", "told the true states"),
        ("gbot+reinit-cold", r"tries gbot\+reinit from a cold start, too"),
        ("magic", "no method 'magic'"),
    ],
)
def test_methods_that_cannot_be_tried_are_refused(method: str, problem: str) -> None:
    with pytest.raises(TrackingError, match=problem):
        check_can_recover([method])


def test_a_pose_is_right_below_a_tenth_of_the_diameter() -> None:
    part = box("box")
    rightness = Rightness([part], interchangeable=False)
    truth = GroundTruth("0", {"box": HERE})
    for share, wrong in ((0.09, ()), (0.11, ("box",))):
        aside = Pose.from_translation(share * part.mesh.diameter_m, 0, 0) @ HERE
        assert rightness.wrong({"box": aside}, truth) == wrong
    assert rightness.wrong({"box": None}, truth) == ("box",)
    assert rightness.wrong({}, truth) == ("box",)


def test_of_a_hidden_part_no_pose_is_asked() -> None:
    rightness = Rightness([box("a"), box("b")], interchangeable=False)
    truth = GroundTruth("0", {"a": HERE, "b": THERE}, {"a": 0.29, "b": 0.3})
    assert rightness.wrong({}, truth) == ("b",)


@pytest.mark.parametrize("interchangeable", [True, False])
def test_parts_of_one_mesh_stand_for_each_other_only_where_nobody_was_told(
    interchangeable: bool,
) -> None:
    twins = [box("a"), box("b"), box("c", (0.04, 0.05, 0.07))]
    rightness = Rightness(twins, interchangeable=interchangeable)
    truth = GroundTruth("0", {"a": HERE, "b": THERE, "c": HERE})
    swapped = {"a": THERE, "b": HERE, "c": HERE}
    assert rightness.wrong(swapped, truth) == (() if interchangeable else ("a", "b"))
    # One place is not two parts.
    assert len(rightness.wrong({"a": HERE, "b": HERE, "c": HERE}, truth)) == 1
    # A part of another mesh is another part.
    assert rightness.wrong({"a": HERE, "b": THERE, "c": THERE}, truth) == ("c",)


@pytest.mark.parametrize("cover", Cover)
def test_a_covered_camera_shows_nothing_of_the_frame(cover: Cover) -> None:
    rng = np.random.default_rng(3)
    color = rng.integers(0, 255, (48, 64, 3)).astype(np.uint8)
    frame = Frame("7", 11, color, np.full((48, 64), 500, np.uint16))
    first, again = (covered(frame, cover, 0.001, np.random.default_rng(1)) for _ in range(2))
    assert (first.name, first.captured_at_ns) == ("7", 11)
    assert first.color.shape == color.shape
    assert first.color.max() < 110
    correlation = np.corrcoef(first.color.ravel(), color.ravel())[0, 1]
    assert abs(correlation) < 0.05
    np.testing.assert_array_equal(first.color, again.color)
    assert first.depth is not None
    if cover is Cover.LENS:
        assert not first.depth.any()
    else:
        assert np.abs(first.depth.astype(float) - 200).max() < 15
    assert covered(replace(frame, depth=None), cover, 0.001, rng).depth is None


def test_the_report_counts_trials_without_end_as_longer_than_any() -> None:
    def result(frames: int | None, kind: TrialKind, asset: str = "vise") -> Recovered:
        wrong = ("pin",) if frames is None else ()
        return Recovered(asset, "normal", "gbot+reinit", kind, 0, frames, 30.0, wrong)

    results = [result(frames, TrialKind.COLD) for frames in (4, 30, None, 31)]
    results += [result(frames, TrialKind.COVERED) for frames in (None, None, 2)]
    text = recovery_markdown(results, "abc", ["vise: gbot+reinit: no network"])
    assert "| gbot+reinit | vise | 4 | 30 | ∞ | 50.0 | 25.0 | pin |" in text
    assert "| gbot+reinit | vise | 3 | ∞ | ∞ | 33.3 | 66.7 | pin |" in text
    assert "a median of at most 30 frames (1 s)" in text
    assert "a median of at most 15 frames (0.5 s)" in text
    assert "Not run: vise: gbot+reinit: no network" in text
    record = recovery_json(results, "abc")
    assert [each["frames"] for each in record["trials"]][:3] == [4, 30, None]
    assert record["figures"][0]["trials"] == 4
