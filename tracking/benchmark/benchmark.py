"""Runs methods over sequences: what is finished is taken from disk, the rest is run and kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from snapfit.models.errors import SnapfitError
from snapfit.tracking.benchmark.provenance import (
    Machine,
    code_version,
    commit,
    data_version,
    load_average,
)
from snapfit.tracking.benchmark.run import Run, run_method
from snapfit.tracking.benchmark.sequences import SequenceFolder, open_sequence
from snapfit.tracking.benchmark.store import Circumstances, RunStore
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.methods import METHODS

QUICK_FRAMES = 100
"""So many frames of each sequence, from the first, make a quick benchmark."""

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Task:
    """One method on one sequence.

    Attributes:
        folder: the sequence.
        method: a name of `METHODS`.
        most_frames: only so many, from the first; None for all.
    """

    folder: SequenceFolder
    method: str
    most_frames: int | None = None

    @property
    def name(self) -> str:
        """For people."""
        return f"{self.folder.name}: {self.method}"


@dataclass(frozen=True, eq=False)
class Outcome:
    """A finished task.

    Attributes:
        task: what was asked.
        run: what came out.
        circumstances: how it was made.
        path: where it is kept.
        is_new: whether it was run now, not taken from disk.
    """

    task: Task
    run: Run
    circumstances: Circumstances
    path: Path
    is_new: bool


def check_methods(methods: Sequence[str]) -> None:
    """Makes sure that there are such methods, before anything is read.

    Raises:
        TrackingError: none, or one that there is not.
    """
    known = ", ".join(METHODS)
    if not methods:
        raise TrackingError(f"no method to benchmark: name some of {known}")
    for method in methods:
        if method not in METHODS:
            raise TrackingError(f"there is no method {method!r}; the methods are {known}")


def run_tasks(
    tasks: Sequence[Task], store: Path, n_jobs: int = 1, progress: Progress | None = None
) -> Iterator[Outcome]:
    """Yields what comes of the tasks, as they are finished.

    Args:
        tasks: what to do.
        store: folder of finished runs.
        n_jobs: tasks side by side, each in a process of its own; with more than one the times
            say little, as they share the processor.
        progress: called with a message and the share of the task that is done; only with one job.

    Raises:
        SnapfitError: of any room; what was finished before is kept.
    """
    code = code_version()
    if n_jobs == 1:
        for task in tasks:
            yield run_task(task, store, code, 1, progress)
        return
    from joblib import Parallel, delayed

    parallel = Parallel(n_jobs=n_jobs, return_as="generator_unordered")
    yield from parallel(delayed(_run_apart)(task, store, code, n_jobs) for task in tasks)


def run_task(
    task: Task, store: Path, code: str, n_jobs: int = 1, progress: Progress | None = None
) -> Outcome:
    """One task, from disk if it is finished there.

    Args:
        task: what to do.
        store: folder of finished runs.
        code: from `code_version`, of the code that is loaded.
        n_jobs: how many tasks run side by side; noted in the result.
        progress: called with a message and the share that is done, 0 to 1.

    Raises:
        SnapfitError: the sequence or a frame cannot be used, or the run cannot be kept.
    """
    recording = open_sequence(task.folder, task.most_frames)
    runs = RunStore(store)
    path = runs.path(task.folder, task.method, data_version(recording), code)
    kept = runs.load(path)
    if kept is not None:
        return Outcome(task, *kept, path, is_new=False)
    run = run_method(task.folder, recording, task.method, progress)
    circumstances = Circumstances(Machine.here(), n_jobs, commit(), load_average())
    runs.save(path, run, circumstances)
    return Outcome(task, run, circumstances, path, is_new=True)


def _run_apart(task: Task, store: Path, code: str, n_jobs: int) -> Outcome:
    """`run_task` in a process of its own: errors with several arguments do not travel."""
    try:
        return run_task(task, store, code, n_jobs)
    except SnapfitError as error:
        raise TrackingError(f"{task.name}: {error}") from None
