"""`--recovery` with the real tracker and finder: parts that lie on the bench and stay there."""

from collections.abc import Callable
from pathlib import Path

import pytest

from snapfit.models.recording import GroundTruth
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.tracking.benchmark.recovery import TrialKind, run_trials
from snapfit.tracking.benchmark.sequences import SequenceFolder, open_sequence

CLAMP = "hobby-corner-clamp"


@pytest.mark.usefixtures("needs_open3d")
def test_a_cold_start_takes_as_long_as_the_finder_and_a_cover_next_to_nothing(
    clamp: tuple, camera: object, lying: dict, draw: Callable, tmp_path: Path
) -> None:
    frame = draw(clamp, lying)
    take = tmp_path / "take"
    # A frame a second: the geometric finder's second is one frame, a cover lasts for two.
    with SequenceWriter(take, camera, asset=CLAMP, frame_rate_hz=1.0) as writer:
        for i in range(8):
            truth = GroundTruth(f"{i:03d}", lying, {}, "parts-free")
            writer.write(truth.frame, frame.color, frame.depth, truth)
    folder = SequenceFolder(CLAMP, "still", take)
    results, problems = run_trials(folder, open_sequence(folder), ["gbot+reinit-geometric", "gbot"])
    assert not problems
    assert [(each.kind, each.method, each.frames) for each in results] == [
        (TrialKind.COLD, "gbot+reinit-geometric", 1),
        (TrialKind.COVERED, "gbot+reinit-geometric", 0),
        (TrialKind.COVERED, "gbot", 0),
    ]
