"""How much a pose is believed, and when a part counts as hidden or lost."""

import dataclasses

import numpy as np
import pytest

from snapfit.tracking.confidence import (
    NO_EVIDENCE,
    Evidence,
    LossJudge,
    LossParameters,
    seen_together,
)
from snapfit.tracking.result import Status

GOOD = Evidence(
    considered=500,
    occluded=0,
    lines=250,
    points=250,
    supporting_lines=240,
    supporting_points=245,
    visible_points=250,
)
CONTRADICTED = dataclasses.replace(GOOD, supporting_lines=10, supporting_points=5)
HIDDEN = dataclasses.replace(
    GOOD, occluded=490, lines=5, points=5, supporting_lines=0, supporting_points=0
)
PATIENCE = LossParameters().lost_after_frames


def test_evidence_is_read_from_the_kernels_counts() -> None:
    counts = np.array([[100, 20, 70, 0], [200, 50, 140, 0]])
    evidence = Evidence.of(counts, np.array([60, 130]))
    assert evidence == Evidence(
        considered=300,
        occluded=70,
        lines=70,
        points=140,
        supporting_lines=60,
        supporting_points=130,
        visible_points=150,
    )
    assert evidence.visibility == pytest.approx(230 / 300)


def test_nothing_in_the_image_is_nothing_visible_and_nothing_believed() -> None:
    nothing = Evidence.of(np.zeros((2, 4), dtype=np.int64), np.zeros(2, dtype=np.int64))
    assert nothing.visibility == 0
    assert nothing.confidence == 0


def test_confidence_is_one_where_everything_agrees() -> None:
    perfect = dataclasses.replace(GOOD, supporting_lines=250, supporting_points=250)
    assert perfect.confidence == 1
    assert 0.9 < GOOD.confidence < 1
    assert CONTRADICTED.confidence < 0.05


@pytest.mark.parametrize(
    "change",
    [
        {"supporting_lines": 200},
        {"supporting_points": 200},
        {"visible_points": 400},
        {"lines": 10, "supporting_lines": 10, "points": 10, "supporting_points": 10},
    ],
    ids=lambda change: ",".join(change),
)
def test_less_agreement_or_less_evidence_is_less_confidence(change: dict[str, int]) -> None:
    assert 0 < dataclasses.replace(GOOD, **change).confidence < GOOD.confidence


def test_what_a_linked_part_lacks_in_evidence_its_carriers_add() -> None:
    little = dataclasses.replace(
        GOOD, lines=20, supporting_lines=20, points=10, supporting_points=10, visible_points=10
    )
    assert little.agreement(None) == little.confidence == pytest.approx(0.5)
    assert little.agreement(GOOD) == pytest.approx(0.5 + 0.5 * GOOD.confidence)
    assert little.agreement(NO_EVIDENCE) == little.confidence
    assert CONTRADICTED.agreement(GOOD) == CONTRADICTED.confidence


def test_colour_alone_reaches_six_tenths() -> None:
    color = dataclasses.replace(
        GOOD, supporting_lines=250, points=0, supporting_points=0, visible_points=0
    )
    assert color.confidence == pytest.approx(0.6)


def test_confidence_stays_between_nought_and_one() -> None:
    rng = np.random.default_rng(1)
    for _ in range(300):
        considered = rng.integers(0, 400, 2)
        occluded = rng.integers(0, considered + 1)
        valid = rng.integers(0, considered - occluded + 1)
        counts = np.stack([considered, occluded, valid, np.zeros(2, dtype=np.int64)], axis=1)
        evidence = Evidence.of(counts, rng.integers(0, valid + 1))
        assert 0 <= evidence.confidence <= 1
        assert 0 <= evidence.visibility <= 1


def test_a_part_that_agrees_is_tracked() -> None:
    judge = LossJudge(1)
    assert {judge.judge(0, GOOD, solved=True) for _ in range(50)} == {Status.TRACKED}


def test_a_hidden_part_is_predicted_for_as_long_as_it_is_hidden() -> None:
    judge = LossJudge(1)
    assert {judge.judge(0, HIDDEN, solved=True) for _ in range(200)} == {Status.PREDICTED}
    assert judge.judge(0, GOOD, solved=True) is Status.TRACKED


def test_a_contradicted_part_is_lost_after_some_patience() -> None:
    judge = LossJudge(1)
    statuses = [judge.judge(0, CONTRADICTED, solved=True) for _ in range(PATIENCE + 3)]
    assert statuses[: PATIENCE - 1] == [Status.TRACKED] * (PATIENCE - 1)
    assert statuses[PATIENCE - 1 :] == [Status.LOST] * 4


def test_one_good_frame_takes_back_what_was_held_against_a_part() -> None:
    judge = LossJudge(1)
    for _ in range(5):
        for _ in range(PATIENCE - 1):
            assert judge.judge(0, CONTRADICTED, solved=True) is Status.TRACKED
        assert judge.judge(0, GOOD, solved=True) is Status.TRACKED


def test_a_lost_part_recovers_when_its_pose_agrees_again() -> None:
    judge = LossJudge(1)
    for _ in range(PATIENCE):
        judge.judge(0, CONTRADICTED, solved=True)
    assert judge.judge(0, CONTRADICTED, solved=True) is Status.LOST
    assert judge.judge(0, GOOD, solved=True) is Status.TRACKED
    assert judge.judge(0, CONTRADICTED, solved=True) is Status.TRACKED


def test_starting_a_part_anew_clears_its_record() -> None:
    judge = LossJudge(2)
    for body in (0, 1):
        for _ in range(PATIENCE):
            judge.judge(body, CONTRADICTED, solved=True)
    judge.reset(0)
    assert judge.judge(0, CONTRADICTED, solved=True) is Status.TRACKED
    assert judge.judge(1, CONTRADICTED, solved=True) is Status.LOST


def test_parts_are_judged_by_themselves() -> None:
    judge = LossJudge(2)
    for _ in range(PATIENCE):
        bad = judge.judge(0, CONTRADICTED, solved=True)
        good = judge.judge(1, GOOD, solved=True)
    assert (bad, good) == (Status.LOST, Status.TRACKED)


@pytest.mark.parametrize("evidence", [GOOD, HIDDEN, CONTRADICTED], ids=["good", "hidden", "bad"])
def test_a_step_that_failed_is_a_loss_whatever_is_seen(evidence: Evidence) -> None:
    assert LossJudge(1).judge(0, evidence, solved=False) is Status.LOST


def test_patience_and_thresholds_can_be_set() -> None:
    judge = LossJudge(
        1, LossParameters(hidden_evidence=600, lost_confidence=0.99, lost_after_frames=1)
    )
    assert judge.judge(0, GOOD, solved=True) is Status.PREDICTED
    plenty = dataclasses.replace(GOOD, lines=400, points=400, visible_points=400)
    assert judge.judge(0, plenty, solved=True) is Status.LOST


def test_what_several_cameras_know_adds_up_and_the_best_view_counts() -> None:
    assert seen_together([GOOD]) == GOOD
    both = seen_together([HIDDEN, GOOD])
    assert both.visibility == GOOD.visibility
    assert both.lines == HIDDEN.lines + GOOD.lines
    assert both.supporting_points == GOOD.supporting_points
    assert not LossJudge(1).is_hidden(both)
    assert LossJudge(1).is_hidden(seen_together([HIDDEN, HIDDEN]))
    assert seen_together([]) == NO_EVIDENCE


def test_depth_alone_is_nothing_where_many_lines_see_no_contour() -> None:
    flat = dataclasses.replace(GOOD, supporting_lines=10, supporting_points=250)
    assert flat.confidence == 0.0
    few_lines = dataclasses.replace(flat, lines=40, supporting_lines=0)
    assert few_lines.confidence == pytest.approx(0.4)


def test_what_is_worse_for_long_becomes_usual_or_is_lost() -> None:
    parameters = LossParameters(doubt=0.8, doubt_frames=20)
    believable = dataclasses.replace(GOOD, supporting_lines=200, supporting_points=70)
    poor = dataclasses.replace(GOOD, supporting_lines=60, supporting_points=120)
    assert poor.confidence < parameters.believable < believable.confidence < 0.8
    for evidence, at_last in ((believable, Status.TRACKED), (poor, Status.LOST)):
        judge = LossJudge(1, parameters)
        judge.judge(0, GOOD, solved=True)
        early = {judge.judge(0, evidence, solved=True) for _ in range(parameters.doubt_frames)}
        assert early == {Status.PREDICTED}
        late = [judge.judge(0, evidence, solved=True) for _ in range(PATIENCE)]
        assert late[-1] is at_last
