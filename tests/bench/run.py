"""All benchmarks but the long ones, one after the other: `make bench`. Takes about ten minutes."""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
from pathlib import Path

import detector_speed
import graph_speed
import serving
import soak
import tracker_speed
import under_load
from figure import Figure
from rich.console import Console
from rich.table import Table

SUITES = {
    "tracking": tracker_speed.run,
    "graph": graph_speed.run,
    "serving": serving.run,
    "load": under_load.run,
    "detector": detector_speed.run,
}
SOAK = "soak"


def main() -> int:
    """Run the suites named on the command line; 1 if a bound is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    choices = [*SUITES, SOAK]
    parser.add_argument("suites", nargs="*", choices=[*choices, []], help="all but soak by default")
    parser.add_argument("--minutes", type=int, default=10, help="of the suite soak, 2 at least")
    wish = parser.parse_args()
    console = Console()
    console.print(f"snapfit {_commit()} on {_cpu()}, {os.cpu_count()} cores, load {_load()}")
    figures = []
    for name in wish.suites or list(SUITES):
        found = soak.run(wish.minutes) if name == SOAK else SUITES[name]()
        figures += [Figure(*figure) for figure in found]
    console.print(_table(figures))
    return 1 if any(figure.is_kept is False for figure in figures) else 0


def _table(figures: list[Figure]) -> Table:
    table = Table()
    for column in ("figure", "value", "bound", ""):
        table.add_column(column)
    marks = {None: "", True: "kept", False: "MISSED"}
    for figure in figures:
        number = f"{figure.value:,.0f}" if figure.value >= 1000 else f"{figure.value:.3g}"
        value = f"{number} {figure.unit}"
        table.add_row(figure.name, value, figure.bound, marks[figure.is_kept])
    return table


def _commit() -> str:
    here = Path(__file__).parent
    command = ["git", "-C", str(here), "describe", "--always", "--dirty"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "of unknown commit"


def _cpu() -> str:
    info = Path("/proc/cpuinfo")
    if info.is_file():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _load() -> str:
    """Of the last minute: figures of a machine that others use too say little."""
    return f"{os.getloadavg()[0]:.1f}"


if __name__ == "__main__":
    sys.exit(main())
