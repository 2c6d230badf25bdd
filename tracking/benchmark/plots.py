"""Errors over time: one picture an asset; with many methods, one an asset and method."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from snapfit.models.asset import PALETTE_RGB
from snapfit.tracking.benchmark.run import Run
from snapfit.tracking.benchmark.scores import PAPER_THRESHOLD_M
from snapfit.tracking.errors import SourceError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_COLUMNS = 3
_LEAST_MM, _MOST_MM = 0.1, 1000.0
_LOST_AT_MM = 700.0


def can_plot() -> bool:
    """Whether matplotlib is here (`pip install 'snapfit[benchmark]'`)."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        return False
    return True


def plot_assets(runs: Sequence[Run], folder: Path) -> None:
    """Draws all pictures: `ASSET.png`, or `ASSET-METHOD.png` where methods are more than three.

    Args:
        runs: of all assets, conditions and methods.
        folder: which is there.

    Raises:
        SourceError: one cannot be written.
    """
    are_many = len({run.method for run in runs}) > _MOST_COLUMNS
    pictures: dict[str, list[Run]] = {}
    for run in runs:
        name = f"{run.asset}-{run.method}" if are_many else run.asset
        pictures.setdefault(name, []).append(run)
    for name, own in pictures.items():
        plot_errors(own, folder / f"{name}.png")


def plot_errors(runs: Sequence[Run], path: Path) -> None:
    """Draws ADD(-S) of every part over time: a row a condition, a column a method.

    Args:
        runs: of one asset.
        path: the PNG to write.

    Raises:
        SourceError: it cannot be written.
    """
    # No pyplot: a figure of its own needs no display and leaves no state behind.
    from matplotlib.figure import Figure

    conditions = list(dict.fromkeys(run.condition for run in runs))
    methods = list(dict.fromkeys(run.method for run in runs))
    size = (1 + 6.5 * len(methods), 0.8 + 2.2 * len(conditions))
    figure = Figure(figsize=size, dpi=110, layout="constrained")
    axes = figure.subplots(len(conditions), len(methods), sharex="row", sharey=True, squeeze=False)
    for run in runs:
        _draw(axes[conditions.index(run.condition)][methods.index(run.method)], run)
    for column in axes[-1]:
        column.set_xlabel("frame")
    _finish(figure, runs, path)


def _draw(axis: Any, run: Run) -> None:
    frames = np.arange(len(run.frames))
    error_mm = np.clip(1000 * run.error("add_m"), _LEAST_MM, _MOST_MM)
    for i, name in enumerate(run.parts):
        color = _color(i)
        seen = run.has_estimate[:, i]
        label = f"{name} (s)" if run.symmetric[i] else name
        axis.plot(frames, np.where(seen, error_mm[:, i], np.nan), color=color, lw=1.2, label=label)
        lost = frames[~seen]
        axis.plot(lost, np.full(len(lost), _LOST_AT_MM), "|", color=color, ms=6)
    axis.axhline(1000 * PAPER_THRESHOLD_M, color="0.6", lw=0.8, ls="--")
    for f in np.flatnonzero(run.true_states[1:] != run.true_states[:-1]) + 1:
        axis.axvline(f, color="0.8", lw=0.8)
    axis.set(yscale="log", ylim=(_LEAST_MM, _MOST_MM), xlim=(0, max(len(frames) - 1, 1)))
    axis.set_title(f"{run.condition}: {run.method}", fontsize=9, loc="left")
    axis.set_ylabel("ADD(-S), mm")
    axis.grid(alpha=0.25)


def _finish(figure: Figure, runs: Sequence[Run], path: Path) -> None:
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    note = "dashes: 10 cm; ticks at the top: no estimate; grey lines: the assembly state changes"
    figure.suptitle(f"{runs[0].asset}   ({note})", fontsize=7)
    try:
        figure.savefig(path, format="png", metadata={"Software": None})
    except OSError as error:
        raise SourceError(f"{path}: cannot be written: {error.strerror}") from error


def _color(part: int) -> tuple[float, float, float]:
    red, green, blue = PALETTE_RGB[part % len(PALETTE_RGB)]
    return red / 255, green / 255, blue / 255
