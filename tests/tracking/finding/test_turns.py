"""Lookouts in turn: one looks at a time, each is asked for what it knows."""

import numpy as np

from snapfit.models.pose import Pose
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.lookout import DelayedLookout
from snapfit.tracking.finding.turns import LookoutsInTurn, in_turn
from snapfit.tracking.frame import Frame


class Finds:
    """Finds what it is asked for, and remembers what that was."""

    def __init__(self, names, problem=None):
        self.names, self.asked, self.problem = names, [], problem

    def find(self, frame, wanted, *_):
        self.asked.append((frame.name, tuple(wanted)))
        if self.problem:
            raise self.problem
        return [Hypothesis(name, Pose.identity(), 1.0) for name in wanted]


def frame(name):
    return Frame(name, 0, np.zeros((4, 4, 3), dtype=np.uint8))


def test_they_look_one_after_the_other_each_with_its_own_delay():
    first, second = Finds(("a", "b")), Finds(("b", "c"))
    lookout = LookoutsInTurn([DelayedLookout(first, 3), DelayedLookout(second, 1)])
    assert lookout.names == ("a", "b", "c")
    told = []
    for k in range(8):
        found = lookout.take()
        if found is not None:
            told.append((k, found.frame, [each.part for each in found.hypotheses]))
        lookout.offer(frame(str(k)), ("a", "b", "c"))
    assert told == [(3, "0", ["a", "b"]), (4, "3", ["b", "c"]), (7, "4", ["a", "b"])]
    assert first.asked == [("0", ("a", "b")), ("4", ("a", "b"))]
    assert second.asked == [("3", ("b", "c")), ("7", ("b", "c"))]
    assert lookout.account.looks == 4
    assert lookout.account.found == 8


def test_one_that_knows_none_of_the_parts_is_passed_over():
    first, second = Finds(("a",)), Finds(("b",))
    lookout = LookoutsInTurn([DelayedLookout(first, 1), DelayedLookout(second, 1)])
    for k in range(4):
        lookout.take()
        assert lookout.offer(frame(str(k)), ("b",))
    assert first.asked == []
    assert len(second.asked) == 4
    lookout.take()
    assert not lookout.offer(frame("4"), ("c",))


def test_nothing_is_offered_while_one_looks():
    first, second = Finds(("a",)), Finds(("a",))
    lookout = LookoutsInTurn([DelayedLookout(first, 5), DelayedLookout(second, 5)])
    assert lookout.offer(frame("0"), ("a",))
    assert not lookout.offer(frame("1"), ("a",))
    assert second.asked == []


def test_what_one_cannot_do_is_counted_and_the_other_goes_on():
    from snapfit.tracking.errors import TrackingError

    first, second = Finds(("a",), TrackingError("no Open3D")), Finds(("a",))
    lookout = LookoutsInTurn([DelayedLookout(first, 1), DelayedLookout(second, 1)])
    answers = []
    for k in range(4):
        found = lookout.take()
        answers += [] if found is None else [len(found.hypotheses)]
        lookout.offer(frame(str(k)), ("a",))
    assert answers == [0, 1, 0]
    assert lookout.account.failed == 2
    assert lookout.account.last_problem == "no Open3D"


def test_a_single_one_stays_as_it_is():
    only = DelayedLookout(Finds(("a",)), 1)
    assert in_turn([only]) is only
