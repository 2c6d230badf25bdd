import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.stats import chi2

from snapfit.tracking.benchmark.benchmark import Outcome, Plan, Task, run_tasks
from snapfit.tracking.benchmark.calibration import N_BINS, calibration, reliability
from snapfit.tracking.benchmark.losses import Loss, losses
from snapfit.tracking.benchmark.reliability_plot import plot_reliability
from snapfit.tracking.benchmark.run import STATUSES, Run
from snapfit.tracking.benchmark.sequences import find_sequences
from snapfit.tracking.errors import SourceError
from snapfit.tracking.result import Status


@pytest.fixture
def run(scripted: Callable, beside: Callable, dataset: Path, tmp_path: Path) -> Run:
    """2 mm beside the truth; the box is lost in the last of six frames."""
    scripted(beside)
    folder = find_sequences(dataset)[0]
    plan = Plan.of(("icg",), tmp_path / "runs")
    (outcome,) = run_tasks([Task(folder, ("icg",))], plan)
    assert isinstance(outcome, Outcome)
    return outcome.run


def test_bins_hold_mean_confidence_and_share_of_right_poses() -> None:
    confidences = np.array([0.0, 0.05, 0.92, 0.94, 0.98, 1.0])
    found = reliability(confidences, np.array([False, True, True, True, False, True]))
    assert found.counts == (2, *[0] * 8, 4)
    assert found.confidences[0] == pytest.approx(0.025)
    assert found.confidences[-1] == pytest.approx(0.96)
    assert (found.right[0], found.right[-1]) == (0.5, 0.75)
    assert all(math.isnan(share) for share in found.right[1:-1])
    gaps = 2 * abs(0.025 - 0.5) + 4 * abs(0.96 - 0.75)
    assert found.calibration_error == pytest.approx(gaps / 6)
    assert math.isnan(reliability(np.empty(0), np.empty(0, bool)).calibration_error)


def test_confidences_that_mean_what_they_say_have_no_calibration_error() -> None:
    rng = np.random.default_rng(0)
    confidences = rng.random(20_000)
    found = reliability(confidences, rng.random(20_000) < confidences)
    assert len(found.counts) == N_BINS
    assert found.calibration_error < 0.02


def test_statuses_and_poses_of_a_run_are_counted(run: Run) -> None:
    found = calibration([run, run])
    assert found.statuses == pytest.approx(
        {"tracked": 11 / 12, "lost": 1 / 12, "searching": 0, "inferred": 0, "predicted": 0}
    )
    assert sum(found.reliability.counts) == 22
    assert found.reliability.counts[9] == 22
    assert found.reliability.calibration_error == pytest.approx(0.1)
    assert found.consistency.mean == pytest.approx((5 * 4 / 6 + 6 * 4 / 5) / 11)
    assert found.consistency.translation == pytest.approx(4 / 3)
    assert found.consistency.rotation == pytest.approx(0, abs=1e-9)
    assert found.consistency.covered == 1


def test_consistency_is_that_of_tracked_parts_with_a_covariance(run: Run) -> None:
    expected = chi2(6)
    nees = np.tile(expected.median() / 6, run.nees.shape)
    nees[0, 0] = 1e9
    nees[1, 0] = np.nan
    nees[2, 0] = expected.ppf(0.96) / 6
    statuses = run.statuses.copy()
    changed = replace(run, nees=nees, statuses=statuses)
    assert calibration([changed]).consistency.mean > 1e6
    assert calibration([changed]).consistency.median == pytest.approx(1)
    assert calibration([changed]).consistency.covered == pytest.approx(8 / 10)
    statuses[0, 0] = STATUSES.index(Status.PREDICTED)
    assert calibration([changed]).consistency.mean < 2
    far = run.errors.copy()
    far[2, 0] = 0.05
    found = calibration([replace(changed, errors=far)]).consistency
    assert found.mean_of_right == pytest.approx(expected.median() / 6)
    statuses[:] = STATUSES.index(Status.LOST)
    assert math.isnan(calibration([changed]).consistency.mean)


def long_run(run: Run, error_m: np.ndarray) -> Run:
    """A run of one part whose tenth of the diameter is 1 cm."""
    n = len(error_m)
    return replace(
        run,
        parts=("jaw",),
        diameters_m=np.array([0.1]),
        errors=np.repeat(error_m[:, None, None], 5, axis=2),
        frames=np.arange(n).astype(str),
    )


@pytest.mark.parametrize(
    ("stretches", "expected"),
    [
        ([], []),
        # Off for a while, by less than 10 cm, and back again.
        ([(10, 40, 0.05)], []),
        ([(10, 40, 0.05), (20, 21, 0.2)], [Loss("jaw", 10, 39, comes_back=True)]),
        ([(10, 12, math.inf)], [Loss("jaw", 10, 11, comes_back=True)]),
        ([(85, 100, 0.05)], [Loss("jaw", 85, 99, comes_back=False)]),
        ([(86, 100, 0.05)], []),
        ([(99, 100, 0.2)], [Loss("jaw", 99, 99, comes_back=False)]),
    ],
)
def test_a_loss_is_far_off_or_for_good(run: Run, stretches: list, expected: list) -> None:
    error_m = np.full(100, 0.001)
    for first, end, value in stretches:
        error_m[first:end] = value
    assert losses(long_run(run, error_m)) == expected


def test_losses_are_told_by_their_frames() -> None:
    assert Loss("jaw", 10, 39, comes_back=True).text == "jaw 10-39"
    assert Loss("jaw", 85, 99, comes_back=False).text == "jaw 85-"


def test_the_reliability_diagram_is_a_picture(run: Run, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    found = calibration([run])
    path = tmp_path / "reliability.png"
    names = [(c, f"m{i}") for i in range(5) for c in ("overall", "normal", "all")]
    plot_reliability(dict.fromkeys(names, found), path)
    image = cv2.imread(str(path))
    assert image is not None
    assert image.shape[1] > image.shape[0] > 600
    assert (image.max(axis=2) < 40).sum() > 500
    plot_reliability({("recorded", "icg"): found}, path)
    assert cv2.imread(str(path)).shape[1] < image.shape[1]
    with pytest.raises(SourceError, match="cannot be written"):
        plot_reliability({("all", "icg"): found}, tmp_path / "nowhere" / "r.png")
