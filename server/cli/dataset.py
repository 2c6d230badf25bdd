"""`snapfit dataset render`: the simulated dataset, written in BOP's format."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from snapfit.server.cli.dataset_runs import (
    render_mistakes_split,
    render_test_split,
    render_train_split,
)
from snapfit.server.cli.errors import clear_errors

dataset_app = typer.Typer(no_args_is_help=True, help="The simulated dataset.")


class Split(StrEnum):
    """Which part of the dataset."""

    TEST = "test"
    TRAIN = "train"
    MISTAKES = "mistakes"


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
    split: Annotated[
        Split,
        typer.Option(help="test: films; train: images; mistakes: films of wrong steps."),
    ] = Split.TEST,
    asset: Annotated[
        list[str] | None, typer.Option(help="An asset, may be repeated; all if absent.")
    ] = None,
    condition: Annotated[
        list[ConditionName] | None,
        typer.Option(help="May be repeated; test: all if absent; mistakes: normal."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of the dataset.")] = Path("dataset"),
    jobs: Annotated[int, typer.Option(help="Processes; -1: one a core.")] = -1,
    backend: Annotated[
        Backend, typer.Option(help="loky: this machine; ray, dask: a cluster.")
    ] = Backend.LOKY,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same pictures.")] = 20,
    limit: Annotated[
        int | None, typer.Option(min=1, help="Test: only the first frames of each scene.")
    ] = None,
    scale: Annotated[
        float,
        typer.Option(min=0.1, max=1.0, help="Of the size: test 1280x720, train 960x540."),
    ] = 1.0,
    renderer: Annotated[
        Renderer, typer.Option(help="cycles: photo-real and slow, by Blender (snapfit[blender]).")
    ] = Renderer.OWN,
    samples: Annotated[
        int, typer.Option(min=1, max=4096, help="Paths of light a pixel, by cycles.")
    ] = 48,
    count: Annotated[
        int | None,
        typer.Option(min=1, help="Train: images of each asset (15000); mistakes: sequences (64)."),
    ] = None,
    depth: Annotated[bool, typer.Option("--depth", help="Train: write depth too.")] = False,
    masks: Annotated[
        bool, typer.Option("--masks", help="Train: write masks as PNG files too.")
    ] = False,
    keypoints: Annotated[
        int | None, typer.Option(min=4, max=200, help="Train: keypoints of a part; 17 if absent.")
    ] = None,
) -> None:
    """Render the dataset; what is there already is kept, so that a run can be taken up again."""
    console = Console(highlight=False)
    is_cycles = renderer is Renderer.CYCLES
    # A cluster's processes stand in other folders.
    out = out.absolute()
    with clear_errors(exit_code=1):
        from snapfit.models.workbench.split import TEST_FRAMES

        names = tuple(dict.fromkeys(asset or TEST_FRAMES))
        if split is Split.TRAIN:
            _refuse(split, {"condition": condition, "limit": limit, "renderer": is_cycles})
            from snapfit.models.keypoints import N_KEYPOINTS
            from snapfit.models.workbench.train_set import N_IMAGES, TrainOrder

            train = TrainOrder(
                out,
                names,
                count=count or N_IMAGES,
                seed=seed,
                depth=depth,
                masks=masks,
                n_keypoints=keypoints or N_KEYPOINTS,
                scale=scale,
            )
            render_train_split(console, train, jobs, backend)
        elif split is Split.MISTAKES:
            own = {"depth": depth, "masks": masks, "keypoints": keypoints}
            _refuse(split, own | {"limit": limit, "renderer": is_cycles})
            from snapfit.models.workbench.mistake_set import N_SEQUENCES, MistakeOrder
            from snapfit.models.workbench.split import Condition

            chosen = tuple(
                Condition(name) for name in dict.fromkeys(condition or [ConditionName.NORMAL])
            )
            wrong = MistakeOrder(out, names, count or N_SEQUENCES, chosen, seed, scale)
            render_mistakes_split(console, wrong, jobs, backend)
        else:
            own = {"count": count, "depth": depth, "masks": masks, "keypoints": keypoints}
            _refuse(split, own)
            from snapfit.models.workbench.dataset import Order
            from snapfit.models.workbench.split import Condition

            chosen = tuple(Condition(name) for name in dict.fromkeys(condition or ConditionName))
            order = Order(out, names, chosen, seed, limit, scale, samples if is_cycles else None)
            render_test_split(console, order, jobs, backend)


def _refuse(split: Split, others: Mapping[str, object]) -> None:
    """Options of the other split are an error, not ignored."""
    for name, value in others.items():
        if value:
            raise typer.BadParameter(f"--{name} does not go with --split {split}")
