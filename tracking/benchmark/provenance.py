"""Where figures come from: command, commit, processor."""

from __future__ import annotations

import os
import platform
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numba

_HOUSE = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Machine:
    """What ran the methods.

    Attributes:
        cpu: the processor's name.
        n_cores: logical cores that this process may use.
        system: operating system and Python.
    """

    cpu: str
    n_cores: int
    system: str

    @classmethod
    def here(cls) -> Machine:
        """This machine."""
        python = f"{platform.python_implementation()} {platform.python_version()}"
        libraries = ", ".join(f"{name} {version(name)}" for name in ("numba", "numpy"))
        return cls(_cpu(), _n_cores(), f"{platform.platform(terse=True)}, {python}, {libraries}")


def command_line() -> str:
    """The command that is running, as it can be typed again."""
    return shlex.join(["snapfit", *sys.argv[1:]])


def commit() -> str:
    """The commit of the checkout that is running, "+" after it where files have changed.

    Outside a checkout: the version of the installed package.
    """
    git = shutil.which("git")
    if git is not None and (_HOUSE / ".git").exists():
        name = _ask(git, "rev-parse", "--short=12", "HEAD")
        if name:
            changed = _ask(git, "status", "--porcelain", "--untracked-files=no")
            return name + ("+" if changed else "")
    return f"snapfit {version('snapfit')}"


def load_average() -> float | None:
    """How many processes wanted to run over the last minute; None where the system does not say."""
    ask = getattr(os, "getloadavg", None)
    return round(ask()[0], 2) if ask else None


def n_threads() -> int:
    """Threads that compiled loops are spread over in this process."""
    return int(numba.get_num_threads())


def _ask(git: str, *arguments: str) -> str:
    command = [git, "-C", str(_HOUSE), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    return done.stdout.strip() if done.returncode == 0 else ""


def _cpu() -> str:
    info = Path("/proc/cpuinfo")
    if info.is_file():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _n_cores() -> int:
    affinity = getattr(os, "sched_getaffinity", None)  # Linux alone has it.
    return len(affinity(0)) if affinity else os.cpu_count() or 1
