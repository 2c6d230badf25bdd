"""What is published of a pose: a probability, and an uncertainty that grows while it is hidden."""

from dataclasses import replace

import numpy as np
import pytest

from snapfit.models.pose import Pose
from snapfit.tracking.calibration import Calibration
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.parameters import ConfidenceParameters, CovarianceParameters
from snapfit.tracking.result import PartEstimate, Status

PARAMETERS = ConfidenceParameters()
COVARIANCE = CovarianceParameters()
SEEN = np.diag([1e-5] * 3 + [1e-6] * 3)
OTHER = 4 * SEEN
TRACKED = PartEstimate("jaw", Status.TRACKED, 1.0, Pose.from_translation(0, 0, 0.7), SEEN)
HIDDEN = replace(TRACKED, status=Status.PREDICTED, confidence=0.0)
LOST = replace(TRACKED, status=Status.LOST, confidence=0.0, camera_from_body=None)


def calibration(n_bodies: int = 1, reachable: float = 1.0) -> Calibration:
    return Calibration(n_bodies, PARAMETERS, COVARIANCE, reachable=reachable)


def published(
    calibration: Calibration, estimate: PartEstimate, covariance: np.ndarray = SEEN
) -> PartEstimate:
    (found,) = calibration.published([estimate], [estimate.confidence], covariance[None])
    return found


def test_more_agreement_is_more_probably_right_and_never_certain() -> None:
    shares = np.linspace(0, 1, 21)
    found = [calibration().probability(share) for share in shares]
    assert (np.diff(found) > 0).all()
    assert found[0] < 0.02
    assert 0.9 < found[-1] < PARAMETERS.best
    assert calibration().probability(PARAMETERS.middle) == pytest.approx(PARAMETERS.best / 2)


def test_without_depth_agreement_is_compared_with_what_colour_can_reach() -> None:
    assert calibration(reachable=0.6).probability(0.6) == calibration().probability(1.0)


def test_a_tracked_part_has_its_own_probability_and_covariance() -> None:
    found = published(calibration(), replace(TRACKED, confidence=0.8), OTHER)
    assert found.confidence == calibration().probability(0.8)
    assert (found.covariance == OTHER).all()
    assert found.camera_from_body is TRACKED.camera_from_body


def test_a_hidden_part_is_believed_less_and_less_and_can_be_further_and_further_off() -> None:
    calibrated = calibration()
    seen = published(calibrated, TRACKED)
    hidden = [published(calibrated, HIDDEN, OTHER) for _ in range(60)]
    confidences = np.array([seen.confidence, *[each.confidence for each in hidden]])
    assert (np.diff(confidences) < 0).all()
    assert confidences[1] > 0.9 * confidences[0]
    assert confidences[-1] < 0.2
    for frames, each in enumerate(hidden, start=1):
        assert each.covariance is not None
        turn, way = frames * COVARIANCE.unseen_turn_rad, frames * COVARIANCE.unseen_way_m
        assert np.allclose(each.covariance, SEEN + np.diag([turn**2] * 3 + [way**2] * 3))
    again = published(calibrated, TRACKED)
    assert again.confidence == seen.confidence
    assert published(calibrated, HIDDEN).confidence == hidden[0].confidence


def test_what_is_hidden_from_the_start_is_known_only_as_far_as_it_is_seen() -> None:
    found = published(calibration(), HIDDEN, OTHER)
    assert found.confidence == calibration().probability(0.0)
    assert (found.covariance == OTHER).all()


def test_a_carried_part_goes_by_those_that_carry_it_and_counts_as_seen() -> None:
    calibrated = calibration()
    carried = replace(TRACKED, status=Status.INFERRED, confidence=0.95)
    found = [published(calibrated, carried, OTHER) for _ in range(40)]
    assert found[-1].confidence == calibrated.probability(0.95)
    assert published(calibrated, HIDDEN).confidence > 0.9 * found[-1].confidence


def test_a_doubtful_part_is_not_remembered() -> None:
    calibrated = calibration()
    published(calibrated, TRACKED)
    doubtful = replace(TRACKED, confidence=0.3)
    for _ in range(60):
        published(calibrated, doubtful)
    assert published(calibrated, HIDDEN).confidence < 0.2


def test_a_lost_part_has_nothing_and_is_forgotten() -> None:
    calibrated = calibration()
    published(calibrated, TRACKED)
    lost = published(calibrated, LOST)
    assert (lost.confidence, lost.covariance) == (0.0, None)
    assert published(calibrated, HIDDEN).confidence == calibrated.probability(0.0)


def test_parts_do_not_share_their_memory() -> None:
    calibrated = calibration(2)
    both = np.stack([SEEN, OTHER])
    calibrated.published([TRACKED, LOST], [1.0, 0.0], both)
    first, second = calibrated.published([HIDDEN, HIDDEN], [0.0, 0.0], both)
    assert first.confidence > 0.9 > 0.1 > second.confidence


@pytest.mark.parametrize("change", [{"steepness": 0.0}, {"memory_frames": -1.0}])
def test_a_map_that_says_nothing_is_refused(change: dict[str, float]) -> None:
    with pytest.raises(TrackingError, match="must be above 0"):
        ConfidenceParameters(**change)


@pytest.mark.parametrize("name", ["information", "prior_rotation_rad", "prior_translation_m"])
def test_a_covariance_of_nothing_is_refused(name: str) -> None:
    with pytest.raises(TrackingError, match=f"{name} is 0"):
        CovarianceParameters(**{name: 0})
