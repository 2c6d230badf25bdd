"""`snapfit dataset render`: the simulated dataset, written in BOP's format."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from snapfit.server.cli.errors import clear_errors

dataset_app = typer.Typer(no_args_is_help=True, help="The simulated dataset.")


class Split(StrEnum):
    """Which part of the dataset."""

    TEST = "test"


class ConditionName(StrEnum):
    """What makes a scene hard to track."""

    NORMAL = "normal"
    DYNAMIC = "dynamic"
    BLUR = "blur"
    HAND = "hand"
    ALL = "all"


class Backend(StrEnum):
    """Where the work is done."""

    LOKY = "loky"
    RAY = "ray"
    DASK = "dask"


class Renderer(StrEnum):
    """What draws the colour pictures."""

    OWN = "own"
    CYCLES = "cycles"


@dataset_app.callback()
def _dataset() -> None:
    """Keep `render` a command of its own though it is the only one."""


@dataset_app.command()
def render(
    split: Annotated[Split, typer.Option(help="Part of the dataset.")] = Split.TEST,
    asset: Annotated[
        list[str] | None, typer.Option(help="An asset, may be repeated; all if absent.")
    ] = None,
    condition: Annotated[
        list[ConditionName] | None, typer.Option(help="May be repeated; all if absent.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of the dataset.")] = Path("dataset"),
    jobs: Annotated[int, typer.Option(help="Processes; -1: one a core.")] = -1,
    backend: Annotated[
        Backend, typer.Option(help="loky: this machine; ray, dask: a cluster.")
    ] = Backend.LOKY,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same pictures.")] = 20,
    limit: Annotated[
        int | None, typer.Option(min=1, help="Only the first frames of each scene.")
    ] = None,
    scale: Annotated[
        float, typer.Option(min=0.1, max=1.0, help="Size of the pictures; 1: 1280x720.")
    ] = 1.0,
    renderer: Annotated[
        Renderer, typer.Option(help="cycles: photo-real and slow, by Blender (snapfit[blender]).")
    ] = Renderer.OWN,
    samples: Annotated[
        int, typer.Option(min=1, max=4096, help="Paths of light a pixel, by cycles.")
    ] = 48,
) -> None:
    """Render the dataset; what is there already is kept, so that a run can be taken up again."""
    del split  # there is one yet
    console = Console(highlight=False)
    with clear_errors(exit_code=1):
        from snapfit.models.workbench.dataset import Order, render_dataset
        from snapfit.models.workbench.split import TEST_FRAMES, Condition

        order = Order(
            directory=out,
            assets=tuple(dict.fromkeys(asset or TEST_FRAMES)),
            conditions=tuple(Condition(name) for name in dict.fromkeys(condition or ConditionName)),
            seed=seed,
            limit=limit,
            scale=scale,
            cycles_samples=samples if renderer is Renderer.CYCLES else None,
        )
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

            summary = render_dataset(order, jobs=jobs, backend=backend, progress=show)
    console.print(_table(summary))
    last = summary["last_rendering"]
    console.print(
        f"{summary['frames']} frames, {summary['megabytes'] / 1000:.2f} GB in {out}; "
        f"{last['frames_per_second']} frames a second"
    )


def _table(summary: dict[str, Any]) -> Table:
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
