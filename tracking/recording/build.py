"""What must be the same for a replay to give the same bits: code, libraries, processor, threads."""

from __future__ import annotations

import hashlib
from pathlib import Path

from snapfit.tracking.benchmark.provenance import Machine, commit, n_threads
from snapfit.tracking.recording.records import BuildRecord

_HOUSE = Path(__file__).resolve().parents[2]
# All that a pose can depend on; sources, the benchmark and recordings themselves are not.
_FOLDERS = (
    "models",
    "tracking",
    "tracking/assembly",
    "tracking/detection",
    "tracking/finding",
    "tracking/kernels",
    "tracking/recovery",
)
_TOLD = {
    "code": "another version of snapfit",
    "libraries": "another system or other libraries",
    "cpu": "another processor",
    "threads": "another number of threads",
}


def build_here() -> BuildRecord:
    """This process."""
    machine = Machine.here()
    return BuildRecord(
        snapfit=commit(),
        code=_code_digest(),
        libraries=machine.system,
        cpu=machine.cpu,
        threads=n_threads(),
    )


def differences(recorded: BuildRecord, here: BuildRecord) -> list[str]:
    """What is not the same, in words; empty where the same bits are to be expected."""
    return [
        f"{words} ({getattr(recorded, key)}, here {getattr(here, key)})"
        for key, words in _TOLD.items()
        if getattr(recorded, key) != getattr(here, key)
    ]


def _code_digest() -> str:
    sha = hashlib.sha256()
    for folder in _FOLDERS:
        for path in sorted((_HOUSE / folder).glob("*.py")):
            sha.update(path.name.encode() + path.read_bytes())
    return sha.hexdigest()[:16]
