"""At a place is one part."""

from snapfit.models.pose import Pose
from snapfit.tracking.confidence import Evidence
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.fits import Fit, in_order
from snapfit.tracking.finding.scoring import Refined


def fit(part: str, shape: int, pieces: set[int], score: float) -> Fit:
    """All lines and points agree; the overlap is the score."""
    evidence = Evidence(200, 0, 100, 100, 100, 100, 100)
    return Fit(part, shape, frozenset(pieces), Refined(Pose.identity(), 0.0, evidence, score))


def told(hypotheses: list[Hypothesis]) -> list[tuple[str, float]]:
    return [(each.part, round(each.score, 2)) for each in hypotheses]


def test_of_two_parts_on_one_cluster_the_surer_is_told():
    fits = [fit("a", 0, {0}, 0.8), fit("b", 1, {0}, 0.9)]
    assert told(in_order(fits)) == [("b", 0.9)]


def test_the_other_is_told_where_else_it_may_be():
    fits = [fit("a", 0, {0}, 0.8), fit("a", 0, {1}, 0.75), fit("b", 1, {0}, 0.9)]
    assert told(in_order(fits)) == [("b", 0.9), ("a", 0.75)]


def test_a_part_and_a_piece_of_it_are_not_two_parts():
    fits = [fit("screw", 0, {0, 1}, 0.9), fit("nut", 1, {1}, 0.8)]
    assert told(in_order(fits)) == [("screw", 0.9)]


def test_alike_parts_get_a_place_each_then_that_of_the_other():
    fits = [
        fit("left", 0, {0}, 0.95),
        fit("left", 0, {1}, 0.9),
        fit("right", 0, {0}, 0.94),
        fit("right", 0, {1}, 0.85),
    ]
    assert told(in_order(fits)) == [
        ("left", 0.95),
        ("right", 0.85),
        ("right", 0.94),
        ("left", 0.9),
    ]


def test_nothing_is_nothing():
    assert in_order([]) == []
