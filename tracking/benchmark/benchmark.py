"""Runs methods over sequences: what is finished is taken from disk, the rest is run and kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from snapfit.models.errors import SnapfitError
from snapfit.tracking.benchmark.contest import run_methods
from snapfit.tracking.benchmark.provenance import Machine, commit, load_average, n_threads
from snapfit.tracking.benchmark.run import Run
from snapfit.tracking.benchmark.sequences import SequenceFolder, open_sequence
from snapfit.tracking.benchmark.store import Circumstances, RunStore
from snapfit.tracking.benchmark.versions import code_version, data_version
from snapfit.tracking.benchmark.weights import input_version, weights

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Task:
    """Methods on one sequence, whose frames are decoded once for all of them.

    Attributes:
        folder: the sequence.
        methods: names of `METHODS`.
        most_frames: only so many frames, from the first; None for all.
    """

    folder: SequenceFolder
    methods: tuple[str, ...]
    most_frames: int | None = None


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a method did on a sequence.

    Attributes:
        folder: the sequence.
        method: its name.
        run: what came out.
        circumstances: how it was made.
        path: where it is kept.
        is_new: whether it was run now, not taken from disk.
    """

    folder: SequenceFolder
    method: str
    run: Run
    circumstances: Circumstances
    path: Path
    is_new: bool


@dataclass(frozen=True)
class Failure:
    """Why there is no run of a method on a sequence.

    Attributes:
        folder: the sequence.
        method: its name.
        problem: for people: what is wrong, where, and what to do.
    """

    folder: SequenceFolder
    method: str
    problem: str


@dataclass(frozen=True)
class Plan:
    """How tasks are done.

    Attributes:
        store: folder of finished runs.
        codes: by method, from `code_version`, of the code that is loaded.
        commit: of that code.
        n_jobs: sequences side by side, each in a process of its own; with more than one the times
            say little, as they share the processor.
        any_code: whether runs that other versions of the code have finished stand too.
    """

    store: Path
    codes: Mapping[str, str]
    commit: str
    n_jobs: int = 1
    any_code: bool = False

    @classmethod
    def of(
        cls, methods: Sequence[str], store: Path, n_jobs: int = 1, *, any_code: bool = False
    ) -> Plan:
        """A plan for these methods in the code that is loaded."""
        codes = {method: code_version(method) for method in methods}
        return cls(store, codes, commit(), n_jobs, any_code)

    def circumstances(self, n_methods: int) -> Circumstances:
        """Of runs that have just ended in this process."""
        here, threads = Machine.here(), n_threads()
        return Circumstances(here, self.n_jobs, self.commit, load_average(), threads, n_methods)


def run_tasks(
    tasks: Sequence[Task], plan: Plan, progress: Progress | None = None
) -> Iterator[Outcome | Failure]:
    """Yields what comes of every method on every sequence, as it is finished.

    What cannot be run does not stop the rest.

    Args:
        tasks: what to do.
        plan: how.
        progress: called with a message and the share of the task that is done; only with one job.

    Raises:
        SourceError: a run cannot be kept, so that no other could be; those before it are.
    """
    if plan.n_jobs == 1:
        for task in tasks:
            yield from run_task(task, plan, progress)
        return
    from joblib import Parallel, delayed

    # Every process gets its share of the cores: joblib tells Numba and BLAS how many threads.
    parallel = Parallel(n_jobs=plan.n_jobs, return_as="generator_unordered", batch_size=1)
    for done in parallel(delayed(run_task)(task, plan) for task in tasks):
        yield from done


def run_task(task: Task, plan: Plan, progress: Progress | None = None) -> list[Outcome | Failure]:
    """One task; of what is finished on disk nothing is run again.

    Args:
        task: what to do.
        plan: how.
        progress: called with a message and the share that is done, 0 to 1.

    Returns:
        One for each method, in their order.

    Raises:
        SourceError: a run cannot be kept.
    """
    runs = RunStore(plan.store)
    done: dict[str, Outcome | Failure] = {}
    try:
        recording = open_sequence(task.folder, task.most_frames)
    except SnapfitError as error:
        return [Failure(task.folder, method, str(error)) for method in task.methods]
    sequence, asset = data_version(recording), recording.asset
    data = {each: input_version(sequence, weights(each, asset)) for each in task.methods}
    for method in task.methods:
        kept = _kept(runs, task.folder, method, data[method], plan)
        if kept is not None:
            done[method] = kept
    missing = [method for method in task.methods if method not in done]
    results: Mapping[str, Run | SnapfitError] = {}
    try:
        if missing:
            results = run_methods(task.folder, recording, missing, progress)
    except SnapfitError as error:
        results = dict.fromkeys(missing, error)
    circumstances = plan.circumstances(len(missing))
    for method, result in results.items():
        if isinstance(result, Run):
            path = runs.path(task.folder, method, data[method], plan.codes[method])
            runs.save(path, result, circumstances)
            done[method] = Outcome(task.folder, method, result, circumstances, path, is_new=True)
        else:
            done[method] = Failure(task.folder, method, str(result))
    return [done[method] for method in task.methods]


def _kept(
    runs: RunStore, folder: SequenceFolder, method: str, data: str, plan: Plan
) -> Outcome | None:
    """A finished run from disk; None where there is none."""
    paths = [runs.path(folder, method, data, plan.codes[method])]
    if plan.any_code:
        paths += runs.paths(folder, method, data)
    for path in paths:
        kept = runs.load(path)
        if kept is not None:
            return Outcome(folder, method, *kept, path, is_new=False)
    return None
