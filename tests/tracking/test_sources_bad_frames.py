from snapfit.tracking.errors import FrameError
from snapfit.tracking.sources.bad_frames import BadFrames


def test_a_fault_is_told_once_and_counted_each_time() -> None:
    told: list[str] = []
    bad_frames = BadFrames(lambda error: told.append(error.frame))
    for loop in range(3):
        bad_frames.add(FrameError("07", "color/07.png: no such file"))
        bad_frames.add(FrameError(f"{loop}", "depth is missing"))
    assert told == ["07", "0"]
    assert bad_frames.count == 6


def test_what_is_remembered_stays_small() -> None:
    told: list[str] = []
    bad_frames = BadFrames(lambda error: told.append(error.frame))
    for i in range(2000):
        bad_frames.add(FrameError(str(i), f"color/{i}.png: no such file"))
    assert bad_frames.count == 2000
    assert len(told) == 1000
