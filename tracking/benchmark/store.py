"""Finished runs on disk: one file for each sequence, method, and version of data and code."""

from __future__ import annotations

import glob
import json
import zipfile
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from snapfit.tracking.benchmark.provenance import Machine
from snapfit.tracking.benchmark.run import Run
from snapfit.tracking.benchmark.sequences import SequenceFolder
from snapfit.tracking.errors import SourceError

_FACTS = "facts"
_NAMES = ("asset", "condition", "method", "parts")
_PLAIN = (*_NAMES, "image_width", "frame_rate_hz", "is_told_state")
_DIGITS = 8


@dataclass(frozen=True)
class Circumstances:
    """How a run was made.

    Attributes:
        machine: where.
        n_jobs: how many sequences ran side by side: over one, times are not to be trusted.
        commit: of the code.
        load: the machine's load average over the last minute of the run; None where unknown.
        n_threads: threads of compiled loops in each of these processes.
        n_methods: methods that tracked in turns, frame by frame, in the same process.
    """

    machine: Machine
    n_jobs: int
    commit: str
    load: float | None = None
    n_threads: int = 1
    n_methods: int = 1


class RunStore:
    """A folder of finished runs; written in one go each, so that half a run is none."""

    def __init__(self, directory: Path) -> None:
        """Opens or makes the folder.

        Raises:
            SourceError: it cannot be made.
        """
        self._directory = directory
        try:
            directory.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise SourceError(f"{directory}: cannot be made: {error.strerror}") from error

    def path(self, folder: SequenceFolder, method: str, data: str, code: str) -> Path:
        """Where the run of a method on a sequence is or will be.

        Args:
            folder: names of asset and condition.
            method: its name.
            data: from `data_version`.
            code: from `code_version`.
        """
        return self._directory / f"{_stem(folder, method, data)}-{code[:_DIGITS]}.npz"

    def paths(self, folder: SequenceFolder, method: str, data: str) -> list[Path]:
        """Runs of a method on a sequence by whatever code, the newest first."""
        pattern = f"{glob.escape(_stem(folder, method, data))}-{'?' * _DIGITS}.npz"
        found = self._directory.glob(pattern)
        return sorted(found, key=lambda path: path.stat().st_mtime, reverse=True)

    def save(self, path: Path, run: Run, circumstances: Circumstances) -> None:
        """Keeps a run.

        Raises:
            SourceError: the file cannot be written.
        """
        names = [field.name for field in fields(Run)]
        arrays: dict[str, Any] = {n: getattr(run, n) for n in names if n not in _PLAIN}
        facts = {name: getattr(run, name) for name in _PLAIN} | asdict(circumstances)
        arrays[_FACTS] = np.array(json.dumps(facts))
        draft = path.with_suffix(".part")
        try:
            with draft.open("wb") as file:
                np.savez_compressed(file, **arrays)
            draft.replace(path)
        except OSError as error:
            draft.unlink(missing_ok=True)
            raise SourceError(f"{path}: cannot be written: {error.strerror}") from error

    def load(self, path: Path) -> tuple[Run, Circumstances] | None:
        """A finished run; None where there is none, or one that cannot be read."""
        try:
            # NumPy leaves a damaged file open that it opens by itself.
            with path.open("rb") as stream, np.load(stream) as file:
                arrays = {name: file[name] for name in file.files}
            facts = json.loads(str(arrays.pop(_FACTS)))
            plain = {name: facts.pop(name) for name in _PLAIN}
            plain["parts"] = tuple(plain["parts"])
            machine = Machine(**facts.pop("machine"))
            return Run(**plain, **arrays), Circumstances(machine, **facts)
        except (OSError, KeyError, TypeError, ValueError, zipfile.BadZipFile, EOFError):
            return None


def _stem(folder: SequenceFolder, method: str, data: str) -> str:
    return f"{folder.name}-{method}-{data[:_DIGITS]}"
