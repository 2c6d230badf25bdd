"""The reliability diagram: stated confidence against the share of right poses."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from snapfit.models.asset import PALETTE_RGB
from snapfit.tracking.benchmark.calibration import N_BINS, Calibration, Reliability
from snapfit.tracking.benchmark.tables import OVERALL
from snapfit.tracking.errors import SourceError

_COLUMNS = 4


def plot_reliability(calibrations: Mapping[tuple[str, str], Calibration], path: Path) -> None:
    """Draws a panel for each method, a line for each condition, and how many poses a bin holds.

    Args:
        calibrations: by condition and method.
        path: the PNG to write.

    Raises:
        SourceError: it cannot be written.
    """
    # No pyplot: a figure of its own needs no display and leaves no state behind.
    from matplotlib.figure import Figure

    methods = list(dict.fromkeys(method for _, method in calibrations))
    n_columns = min(len(methods), _COLUMNS)
    n_rows = -(-len(methods) // n_columns)
    size = (1.0 + 3.6 * n_columns, 0.6 + 3.5 * n_rows)
    figure = Figure(figsize=size, dpi=110, layout="constrained")
    axes = figure.subplots(n_rows, n_columns, sharex=True, sharey=True, squeeze=False)
    for axis in axes.flat[len(methods) :]:
        axis.set_axis_off()
    for method, axis in zip(methods, axes.flat, strict=False):
        own = {name: each.reliability for (name, m), each in calibrations.items() if m == method}
        _draw(axis, method, own)
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3 * n_columns, fontsize=8)
    try:
        figure.savefig(path, format="png", metadata={"Software": None})
    except OSError as error:
        raise SourceError(f"{path}: cannot be written: {error.strerror}") from error


def _draw(axis: Any, method: str, conditions: Mapping[str, Reliability]) -> None:
    axis.plot([0, 1], [0, 1], color="0.6", lw=0.8, ls="--", label="as stated")
    others = [name for name in conditions if name != OVERALL]
    for i, name in enumerate(others):
        each = conditions[name]
        color = tuple(channel / 255 for channel in PALETTE_RGB[i])
        axis.plot(each.confidences, each.right, ".-", color=color, lw=1, ms=4, label=name)
    whole = conditions.get(OVERALL, conditions[others[0]] if others else None)
    if whole is None:
        return
    if OVERALL in conditions:
        axis.plot(
            whole.confidences, whole.right, "o-", color="0.2", lw=3, ms=5, zorder=1.5, label=OVERALL
        )
    shares = np.array(whole.counts) / max(sum(whole.counts), 1)
    centers = (np.arange(N_BINS) + 0.5) / N_BINS
    axis.bar(centers, shares, 0.9 / N_BINS, color="0.85", zorder=0, label="share of poses")
    error = 100 * whole.calibration_error
    axis.set_title(f"{method}: ECE {error:.1f} %", fontsize=9, loc="left")
    axis.set(xlim=(0, 1), ylim=(0, 1.02), xlabel="confidence", ylabel="ADD(-S) < 0.1 d")
    axis.grid(alpha=0.25)
