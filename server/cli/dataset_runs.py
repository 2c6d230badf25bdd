"""`snapfit dataset render` at work: the progress bar, and what is said at the end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

if TYPE_CHECKING:
    from snapfit.models.workbench.dataset import Order
    from snapfit.models.workbench.mistake_set import MistakeOrder
    from snapfit.models.workbench.train_set import TrainOrder


def render_test_split(console: Console, order: Order, jobs: int, backend: str) -> None:
    """Renders the test split and shows its figures.

    Raises:
        SnapfitError: as `render_dataset`.
    """
    from snapfit.models.workbench.dataset import render_dataset

    with _counted(console) as show:
        summary = render_dataset(order, jobs=jobs, backend=backend, progress=show)
    console.print(_scenes(summary))
    last = summary["last_rendering"]
    console.print(
        f"{summary['frames']} frames, {summary['megabytes'] / 1000:.2f} GB in {order.directory}; "
        f"{last['frames_per_second']} frames a second"
    )


def render_train_split(console: Console, order: TrainOrder, jobs: int, backend: str) -> None:
    """Renders the training split and shows its figures.

    Raises:
        SnapfitError: as `render_train_set`.
    """
    from snapfit.models.workbench.train_set import render_train_set

    with _counted(console) as show:
        summary = render_train_set(order, jobs=jobs, backend=backend, progress=show)
    table = Table("asset", "images", "with joined parts", "parts", "mean visibility", "MB")
    for name, figures in summary["assets"].items():
        words = [str(figures[key]) for key in ("images", "assembled", "instances")]
        table.add_row(name, *words, str(figures["mean_visibility"]), str(figures["megabytes"]))
    console.print(table)
    last = summary["last_rendering"]
    console.print(
        f"{last['images']} images rendered into {order.directory}; "
        f"{last['images_per_second']} images a second"
    )


def render_mistakes_split(console: Console, order: MistakeOrder, jobs: int, backend: str) -> None:
    """Renders the split of mistakes and shows what is in it.

    Raises:
        SnapfitError: as `render_mistakes`.
    """
    from snapfit.models.workbench.mistake import MistakeKind
    from snapfit.models.workbench.mistake_set import render_mistakes

    with _counted(console) as show:
        summary = render_mistakes(order, jobs=jobs, backend=backend, progress=show)
    table = Table("asset", *(kind.replace("_", " ") for kind in MistakeKind))
    made = [(folder.asset, mistake.kind) for folder, mistake in summary["sequences"]]
    for asset in dict.fromkeys(asset for asset, _ in made):
        table.add_row(asset, *(str(made.count((asset, kind))) for kind in MistakeKind))
    console.print(table)
    console.print(
        f"{len(made)} sequences in {order.directory}; {summary['frames']} frames rendered "
        f"in {summary['seconds']} s"
    )


@contextmanager
def _counted(console: Console) -> Iterator[Callable[[int, int], None]]:
    """A progress bar; gives the function that moves it on, to be called with done and total."""
    columns = (
        TextColumn("rendering"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("rendering", total=None)

        def show(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)

        yield show


def _scenes(summary: dict[str, Any]) -> Table:
    table = Table("scene", "frames", "mm a frame", "deg a frame", "in view", "hidden", "frames/s")
    for name, figures in summary["scenes"].items():
        motion, seen = figures["motion"], figures["visibility_in_hand"]
        table.add_row(
            name,
            str(figures["frames"]),
            f"{motion['median_mm']:.1f} (peak {motion['peak_mm']:.0f})",
            f"{motion['median_deg']:.1f} (peak {motion['peak_deg']:.0f})",
            "" if seen is None else f"{100 * seen:.0f} %",
            ", ".join(map(str, figures["hidden_stretches"])),
            str(figures.get("frames_per_core_second", "")),
        )
    return table
