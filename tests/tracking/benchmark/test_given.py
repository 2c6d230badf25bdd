"""What a method is given beside the frames: first poses or none, and a network of the asset."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from snapfit.models.pose import Pose
from snapfit.tracking.benchmark import benchmark as benchmark_module
from snapfit.tracking.benchmark.benchmark import Outcome, Plan, Task, run_tasks
from snapfit.tracking.benchmark.scores import run_score
from snapfit.tracking.benchmark.sequences import find_sequences


@pytest.fixture
def task(dataset: Path) -> Task:
    return Task(find_sequences(dataset, ["clamp"])[0], ("icg",))


def ran(task: Task, store: Path, **more: bool) -> list[Outcome]:
    """What came out; nothing may have failed."""
    outcomes = []
    for each in run_tasks([task], Plan.of(task.methods, store, **more)):
        assert isinstance(each, Outcome), each
        outcomes.append(each)
    return outcomes


def test_a_method_that_finds_its_parts_is_given_no_first_pose(
    scripted: Callable, beside: Callable, methods: dict, task: Task, tmp_path: Path
) -> None:
    def late(number: int, part: str, truth: Pose) -> Pose | None:
        return None if number < 2 else beside(number, part, truth)

    trackers = scripted(late)
    cold, warm = ran(replace(task, methods=("cold", "icg")), tmp_path / "runs")
    assert trackers[0].started == {}
    assert set(trackers[1].started) == {"box", "pin"}
    # Frames before the first find are failures like any others.
    assert np.isinf(cold.run.error("add_m")[:2]).all()
    assert run_score(cold.run).lost == pytest.approx(100 * 5 / 12)
    np.testing.assert_array_equal(cold.run.errors[2:], warm.run.errors[2:])


def test_a_run_with_another_network_does_not_stand(
    scripted: Callable,
    beside: Callable,
    task: Task,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    network = tmp_path / "detector.onnx"
    monkeypatch.setattr(benchmark_module, "weights", lambda *_: (network,))
    trackers = scripted(beside)
    for content, made in ((b"one", 1), (b"one", 1), (b"two", 2), (b"one", 2)):
        network.write_bytes(content)
        # Even where runs of other code stand: weights are no code.
        ran(task, tmp_path / "runs", any_code=True)
        assert len(trackers) == made
