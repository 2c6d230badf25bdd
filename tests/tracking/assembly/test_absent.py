"""A linked part whose place is seen without it has come off, wherever it is now."""

from toy import BESIDE, ON_BOARD, toy

from snapfit.models.pose import Pose
from snapfit.tracking.assembly.estimate import PartObservation
from snapfit.tracking.assembly.judge import StateJudge
from snapfit.tracking.assembly.parameters import AssemblyParameters
from snapfit.tracking.result import Status

LONG = AssemblyParameters().absent_frames


def seen(name, pose):
    return PartObservation(name, Status.TRACKED, 0.9, pose, None, 1.0, pose)


def inferred(name, pose, *, is_absent, visibility=1.0):
    status = Status.INFERRED
    return PartObservation(
        name, status, 0.9, pose, None, visibility, pose, is_sure=False, is_absent=is_absent
    )


class Bench:
    """The left block is put on the board, and then only its link tells where it is."""

    def __init__(self):
        self.judge, self.frame = StateJudge(toy()), 0
        for _ in range(30):
            self.look(seen("left", ON_BOARD["left"]))
        assert self.judge.state == "left-on"

    def look(self, left):
        others = [seen("board", Pose.identity()), seen("right", BESIDE["right"])]
        self.frame += 1
        return self.judge.update([*others, left], self.frame)


def test_a_part_that_is_absent_for_long_has_come_off():
    bench = Bench()
    absent = inferred("left", ON_BOARD["left"], is_absent=True)
    for _ in range(LONG - 1):
        assert bench.look(absent).state == "left-on"
    estimate = bench.look(absent)
    assert estimate.state == "free"
    assert estimate.changed is not None
    assert not estimate.changed.is_forward
    assert estimate.changed.steps == ("put-left",)


def test_a_part_that_is_hidden_in_its_place_stays():
    bench = Bench()
    hidden = inferred("left", ON_BOARD["left"], is_absent=False, visibility=0.0)
    assert {bench.look(hidden).state for _ in range(10 * LONG)} == {"left-on"}


def test_frames_in_which_it_is_seen_there_speak_against_it():
    bench = Bench()
    absent = inferred("left", ON_BOARD["left"], is_absent=True)
    there = seen("left", ON_BOARD["left"])
    states = set()
    for _ in range(4 * LONG):
        states.add(bench.look(absent).state)
        states |= {bench.look(there).state for _ in range(3)}
    assert states == {"left-on"}
