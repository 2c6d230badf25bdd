"""Parts that are made alike: whose estimate counts as whose."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.pose import Pose
from snapfit.tracking.benchmark import roster
from snapfit.tracking.benchmark.instances import instances, matched
from snapfit.tracking.benchmark.notes import Notes
from snapfit.tracking.benchmark.sequences import find_sequences, open_sequence
from snapfit.tracking.result import PartEstimate, Status, TrackingResult

JAW = find_asset("hobby-corner-clamp").tracked_parts[1]
PARTS = [replace(JAW, name="one"), find_asset("hobby-corner-clamp").tracked_parts[0]]
PARTS += [replace(JAW, name=name) for name in ("two", "three")]
PLACES = {"one": 0.0, "base": 0.1, "two": 0.2, "three": 0.3}
TRUTH = {name: Pose.from_translation(x, 0, 0.5) for name, x in PLACES.items()}


def poses(*along_x: float | None) -> np.ndarray:
    """(1, P, 4, 4), a pose a part, None: no estimate."""
    found = np.full((1, len(PARTS), 4, 4), np.nan)
    for column, x in enumerate(along_x):
        if x is not None:
            found[0, column] = Pose.from_translation(x, 0, 0.5).matrix
    return found


def test_only_parts_of_one_mesh_are_instances() -> None:
    assert instances(PARTS) == [[0, 2, 3]]
    assert instances(PARTS[:2]) == []


def test_estimates_count_for_the_instances_they_are_nearest_to() -> None:
    found = poses(0.29, 0.21, 0.01, 0.19)  # another mesh at 0.21 counts for itself alone
    assert matched(found, [TRUTH], PARTS).tolist() == [[2, 1, 3, 0]]


def test_no_estimate_counts_twice_and_a_missing_one_stays_missing() -> None:
    found = poses(None, 0.1, 0.01, 0.02)
    columns = matched(found, [TRUTH], PARTS)[0]
    assert sorted(columns) == [0, 1, 2, 3]
    assert columns[0] == 2
    assert columns[3] == 0  # the farthest has none


def test_who_is_told_first_poses_is_to_know_its_parts() -> None:
    assert roster.is_told_poses("gbot+reinit")
    assert not roster.is_told_poses("gbot+reinit-cold")
    assert not roster.is_told_poses("yolov8pose")


@pytest.mark.parametrize("is_told_poses", [False, True])
def test_who_was_told_no_poses_may_take_twins_for_each_other(
    dataset: Path, is_told_poses: bool
) -> None:
    folder = find_sequences(dataset, ["clamp"])[0]
    recording = open_sequence(folder)
    box, pin = recording.parts
    notes = Notes(replace(recording, parts=(box, replace(box, name=pin.name))))
    truth = recording.truth["000"].camera_from_body
    swapped = ((box.name, truth[pin.name], 0.9), (pin.name, truth[box.name], 0.4))
    said = tuple(PartEstimate(name, Status.TRACKED, sure, pose) for name, pose, sure in swapped)
    notes.take(0, TrackingResult("000", 0, said, 1.0), (1.0, 1.0))
    run = notes.judged(folder, "x", is_told_state=False, is_told_poses=is_told_poses)
    assert (run.error("translation_m") < 1e-6).all() != is_told_poses
    assert run.confidences.tolist() == [[0.9, 0.4] if is_told_poses else [0.4, 0.9]]
