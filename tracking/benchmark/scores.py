"""Scores of runs: the GBOT paper's, and strict ones beside them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from snapfit.tracking.benchmark.run import Run
from snapfit.tracking.benchmark.states import NO_STATES, judge_states
from snapfit.tracking.metrics import area_under_curve, average_recall, quantile, recall

PAPER_THRESHOLD_M = 0.1
STRICT_THRESHOLD_M = 0.02
STRICT_SHARE = 0.1
BOP_SHARES = np.arange(1, 11) * 0.05
"""Thresholds of BOP's average recalls: of the diameter for MSSD; for MSPD they are 5 r to 50 r
pixels with r = width / 640 px (Hodan et al. 2020)."""

MISSED_TRANSLATION_M = PAPER_THRESHOLD_M
MISSED_ROTATION_RAD = math.pi
"""What a frame without estimate counts in the means of the paper."""


@dataclass(frozen=True)
class Score:
    """One row of the tables, or one part of it. Shares are in percent; NaN means no answer.

    Attributes:
        add_score: the paper's s_i at 10 cm (GBOT, eq. for s_i), %.
        under_10_cm: frames whose ADD(-S) is under 10 cm, %.
        translation_cm: mean e_trans; no estimate counts as 10 cm.
        rotation_deg: mean e_rot of parts without symmetry; no estimate counts as 180 degrees.
        time_ms: mean time of a frame by the clock.
        cpu_ms: mean time of a frame in time of a core.
        add_recall: frames whose ADD(-S) is under 10 % of the diameter, %.
        add_auc: area under the recall of ADD(-S) up to 2 cm, %.
        mssd_recall, mspd_recall: BOP's average recalls, %.
        mssd_mm, mspd_px: medians.
        lost: frames without an estimate, %.
        state_accuracy: frames with the true assembly state, %.
        settled_accuracy: the same of frames more than 10 away from a true switch, %.
        switch_delay: mean delay of noticed switches, frames.
        switches_found: switches noticed within 10 frames, early or late, %.
        switches_missed: switches not noticed before the next one, %.
        switches_beyond: changes of state that were reported beyond the true ones, a sequence.
        alarms: parts reported to sit wrong, each time anew, a sequence.
    """

    add_score: float
    under_10_cm: float
    translation_cm: float
    rotation_deg: float
    time_ms: float
    cpu_ms: float
    add_recall: float
    add_auc: float
    mssd_recall: float
    mspd_recall: float
    mssd_mm: float
    mspd_px: float
    lost: float
    state_accuracy: float = math.nan
    settled_accuracy: float = math.nan
    switch_delay: float = math.nan
    switches_found: float = math.nan
    switches_missed: float = math.nan
    switches_beyond: float = math.nan
    alarms: float = math.nan


def part_scores(run: Run) -> dict[str, Score]:
    """The score of each part of a run; states belong to the run alone."""
    return {name: _score(run, [i]) for i, name in enumerate(run.parts)}


def run_score(run: Run) -> Score:
    """The score of a run over all its parts and frames; of states that it was told, none."""
    return _score(run, range(len(run.parts)), **({} if run.is_told_state else _states(run)))


def mean_score(scores: Sequence[Score]) -> Score:
    """The mean of rows, as the paper's last row; what a row does not answer is left out of it."""
    values = {}
    for field in fields(Score):
        answers = [getattr(score, field.name) for score in scores]
        answers = [answer for answer in answers if not math.isnan(answer)]
        values[field.name] = float(np.mean(answers)) if answers else math.nan
    return Score(**values)


def _score(run: Run, parts: Sequence[int], **states: float) -> Score:
    add_m, mssd_m, mspd_px = (run.error(name)[:, parts] for name in ("add_m", "mssd_m", "mspd_px"))
    relative = (run.error("mssd_m") / run.diameters_m)[:, parts]
    plain = [i for i in parts if not run.symmetric[i]]
    translation_m = _counted(run.error("translation_m")[:, parts], MISSED_TRANSLATION_M)
    rotation_rad = _counted(run.error("rotation_rad")[:, plain], MISSED_ROTATION_RAD)
    return Score(
        add_score=100 * area_under_curve(add_m, PAPER_THRESHOLD_M),
        under_10_cm=100 * recall(add_m, PAPER_THRESHOLD_M),
        translation_cm=100 * translation_m,
        rotation_deg=math.degrees(rotation_rad),
        time_ms=float(run.times_ms.mean()),
        cpu_ms=float(run.cpu_ms.mean()),
        add_recall=100 * float(run.is_within(STRICT_SHARE)[:, parts].mean()),
        add_auc=100 * area_under_curve(add_m, STRICT_THRESHOLD_M),
        mssd_recall=100 * average_recall(relative, BOP_SHARES),
        mspd_recall=100 * average_recall(mspd_px / run.image_width * 640, 100 * BOP_SHARES),
        mssd_mm=1000 * quantile(mssd_m, 0.5),
        mspd_px=quantile(mspd_px, 0.5),
        lost=100 * float((~run.has_estimate[:, parts]).mean()),
        **states,
    )


def _states(run: Run) -> dict[str, float]:
    states = judge_states(run.true_states.tolist(), run.states.tolist())
    if states is NO_STATES:
        return {}
    n = states.n_switches
    return {
        "state_accuracy": 100 * states.accuracy,
        "settled_accuracy": 100 * states.settled_accuracy,
        "switch_delay": states.delay_frames,
        "switches_found": 100 * states.n_found / n if n else math.nan,
        "switches_missed": 100 * states.n_missed / n if n else math.nan,
        "switches_beyond": float(states.n_reported - n),
        "alarms": float(np.diff(run.misassembled, axis=0, prepend=False)[run.misassembled].sum()),
    }


def _counted(errors: np.ndarray, missed: float) -> float:
    """The mean, with what is missing counted as a failure; not a number without any."""
    if not errors.size:
        return math.nan
    return float(np.where(np.isfinite(errors), errors, missed).mean())
