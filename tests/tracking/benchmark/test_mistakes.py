"""Reports of wrong parts are judged: in time, the right part, the right kind, and no others."""

from dataclasses import replace

import numpy as np
import pytest

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.models.workbench.mistake import Mistake, MistakeFolder, MistakeKind, write_mistake
from snapfit.tracking.assembly.estimate import AssemblyEstimate, Misassembly, MisassemblyKind
from snapfit.tracking.benchmark import mistakes
from snapfit.tracking.benchmark.mistakes import check_can_judge, judge_mistake, median_delay
from snapfit.tracking.benchmark.mistakes_report import (
    mistakes_json,
    mistakes_markdown,
    summary_line,
)
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.result import PartEstimate, Status, TrackingResult

CLAMP = "hobby-corner-clamp"
N_FRAMES, REST = 60, 10
SMALL = PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5)
MISTAKE = Mistake(
    kind=MistakeKind.WRONG_PLACE,
    part="jaw",
    parent="base",
    state="parts-free",
    rest_frame=REST,
    translation_m=0.04,
    rotation_deg=5.0,
    visibility=0.9,
)
POSES = {
    name: Pose.from_translation(0.1 * i, 0, 0.5) for i, name in enumerate(("base", "jaw", "bolt"))
}


class ScriptedTracker:
    """Reports what it is given: (part, kind, first frame, last frame); the jaw 2 mm aside."""

    def __init__(self, reports, state="parts-free", jaw_lost=False):
        self.reports, self.state, self.jaw_lost = reports, state, jaw_lost
        self.told = []

    def start(self, _frame, camera_from_body):
        assert set(camera_from_body) == set(POSES)

    def set_state(self, state):
        self.told.append(state)

    def track(self, frame):
        number = int(frame.name)
        found = tuple(
            Misassembly(part, "base", kind, number, 0.04, 0.1)
            for part, kind, first, last in self.reports
            if first <= number <= last
        )
        aside = Pose.from_translation(0.002, 0, 0)
        parts = tuple(
            PartEstimate(name, Status.TRACKED, 0.9, aside @ pose if name == "jaw" else pose)
            for name, pose in POSES.items()
        )
        if self.jaw_lost:
            lost = PartEstimate("jaw", Status.LOST, 0.0, None)
            parts = tuple(lost if each.part == "jaw" else each for each in parts)
        estimate = AssemblyEstimate(self.state, 1.0, None, (), (), found)
        return TrackingResult(frame.name, frame.captured_at_ns, parts, 1.0, self.state, estimate)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("data") / CLAMP / "mistakes" / "000007"
    directory.parent.mkdir(parents=True)
    camera = RgbdCamera(SMALL, SMALL)
    with SequenceWriter(directory, camera, asset=CLAMP) as writer:
        for i in range(N_FRAMES):
            truth = GroundTruth(f"{i:03d}", POSES, dict.fromkeys(POSES, 1.0), "parts-free")
            color = np.full((48, 64, 3), 90, np.uint8)
            writer.write(truth.frame, color, np.full((48, 64), 500, np.uint16), truth)
    write_mistake(directory, MISTAKE)
    return MistakeFolder(CLAMP, directory)


@pytest.fixture
def judged(folder, monkeypatch):
    """Judges a scripted tracker."""

    def judge(*reports, **more):
        tracker = ScriptedTracker(reports, **more)
        monkeypatch.setattr(mistakes, "create_tracker", lambda *_, **__: tracker)
        verdict = judge_mistake(folder, "gbot")
        assert tracker.told == ["parts-free"]
        return verdict

    return judge


PLACE, PART = MisassemblyKind.WRONG_PLACE, MisassemblyKind.WRONG_PART


def test_a_report_in_time_counts_with_its_delay(judged):
    verdict = judged(("jaw", PLACE, REST + 20, N_FRAMES))
    assert verdict.is_named
    assert verdict.is_state_right
    assert verdict.delay_frames == 20
    assert verdict.false_events == ()
    assert verdict.off_mm == pytest.approx(2.0)
    assert verdict.off_deg == pytest.approx(0.0)
    assert verdict.is_pose_right


def test_the_last_word_on_the_kind_counts(judged):
    verdict = judged(("jaw", PLACE, 30, 39), ("jaw", PART, 40, N_FRAMES))
    assert verdict.is_found
    assert not verdict.is_named
    assert verdict.reported_kind == "wrong_part"


@pytest.mark.parametrize(
    ("first", "is_found"), [(REST, True), (REST + 45, True), (REST + 46, False), (99, False)]
)
def test_too_late_is_not_found(judged, first, is_found):
    verdict = judged(("jaw", PLACE, first, N_FRAMES))
    assert verdict.is_found is is_found
    assert (verdict.reported_kind == "wrong_place") is is_found
    assert (verdict.delay_frames is None) is (first >= N_FRAMES)


def test_other_parts_and_parts_not_at_rest_are_false_events(judged):
    verdict = judged(
        ("bolt", PART, 20, 22),
        ("bolt", PLACE, 30, 31),
        ("jaw", PLACE, REST - 3, REST - 1),
        ("jaw", PLACE, REST + 25, N_FRAMES),
    )
    assert verdict.false_events == (
        "7: jaw wrong_place",
        "20: bolt wrong_part",
        "30: bolt wrong_place",
    )
    assert verdict.delay_frames == 25


def test_a_step_taken_for_done_and_a_lost_part_are_told(judged):
    verdict = judged(state="jaw-mounted", jaw_lost=True)
    assert not verdict.is_state_right
    assert verdict.off_mm is None
    assert not verdict.is_pose_right


def test_the_report_counts_by_kind_and_asset(judged):
    good = judged(("jaw", PLACE, REST + 20, N_FRAMES))
    late = judged(("jaw", PLACE, REST + 46, N_FRAMES), ("bolt", PART, 5, 6), jaw_lost=True)
    other = replace(late, mistake=MISTAKE.model_copy(update={"kind": MistakeKind.WRONG_ORDER}))
    assert "Commit: c0ffee" in mistakes_markdown([good], "c0ffee")
    text = mistakes_markdown([good, late, other], "c0ffee")
    assert "| gbot | wrong place | 2 | 50.0 | 50.0 | 20 | 1 | 100.0 | 50.0 |" in text
    assert "| gbot | wrong order | 1 | 0.0 | 0.0 | - | 1 | 100.0 | 0.0 |" in text
    assert "| gbot | all | 3 | 33.3 | 33.3 | 20 | 2 | 100.0 | 33.3 |" in text
    assert f"| gbot | {CLAMP} 000007 | jaw: wrong place | 46 | - | 5: bolt wrong_part |" in text
    record = mistakes_json([good, late], "c0ffee")
    whole = next(each for each in record["figures"] if each["group"] == "all")
    assert (whole["sequences"], whole["found_percent"], whole["false_events"]) == (2, 50.0, 1)
    assert [each["is_found"] for each in record["sequences"]] == [True, False]
    assert list(summary_line([good, late])) == [
        "gbot: 1 of 2 found, 1 with the right kind, 20 frames after the rest; 1 false events"
    ]
    assert np.isnan(median_delay([late]))


def test_methods_that_judge_no_assembly_are_refused():
    check_can_judge(["gbot"])
    for method in ("icg", "mbicg"):
        with pytest.raises(TrackingError, match=rf"{method} does not judge .* needs one of.* gbot"):
            check_can_judge(["gbot", method])
    with pytest.raises(TrackingError, match="there is no method 'magic'"):
        check_can_judge(["magic"])


def test_a_sequence_that_ends_too_early_is_refused(folder, monkeypatch):
    late = MISTAKE.model_copy(update={"rest_frame": N_FRAMES - 45})
    monkeypatch.setattr(mistakes, "read_mistake", lambda _: late)
    with pytest.raises(TrackingError, match="ends less than 45 frames after"):
        judge_mistake(folder, "gbot")
