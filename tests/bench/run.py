"""All benchmarks, one after the other: `make bench`. Takes about seven minutes."""

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
import tracker_speed
from figure import Figure
from rich.console import Console
from rich.table import Table

SUITES = {
    "tracking": tracker_speed.run,
    "graph": graph_speed.run,
    "serving": serving.run,
    "detector": detector_speed.run,
}


def main() -> int:
    """Run the suites named on the command line, all by default; 1 if a bound is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("suites", nargs="*", choices=[*SUITES, []], help="all by default")
    names = parser.parse_args().suites or list(SUITES)
    console = Console()
    console.print(f"snapfit {_commit()} on {_cpu()}, {os.cpu_count()} cores")
    figures = []
    for name in names:
        figures += [Figure(*figure) for figure in SUITES[name]()]
    console.print(_table(figures))
    return 1 if any(figure.is_kept is False for figure in figures) else 0


def _table(figures: list[Figure]) -> Table:
    table = Table()
    for column in ("figure", "value", "bound", ""):
        table.add_column(column)
    marks = {None: "", True: "kept", False: "MISSED"}
    for figure in figures:
        value = f"{figure.value:.3g} {figure.unit}"
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


if __name__ == "__main__":
    sys.exit(main())
