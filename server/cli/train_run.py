"""`snapfit train` at work: what it needs, the progress bar, and what is said at the end."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from snapfit.models.errors import TrainingError
from snapfit.server.cli.dataset_runs import render_train_split

if TYPE_CHECKING:
    from snapfit.models.asset import Asset
    from snapfit.models.detector.card import DetectorCard
    from snapfit.models.detector.device import Workplace
    from snapfit.models.detector.recipe import Recipe
    from snapfit.models.detector.size import NetworkSize
    from snapfit.models.detector.train import Report
    from snapfit.models.train_reader import TrainSet


def require_libraries() -> None:
    """Makes sure that training is installed, before anything is rendered.

    Raises:
        TrainingError: PyTorch or onnx is missing.
    """
    try:
        import onnx  # noqa: F401
        import torch  # noqa: F401
    except ImportError as error:
        problem = f"training needs more than snapfit itself ({error}): pip install 'snapfit[train]'"
        raise TrainingError(problem) from error


def pixels(text: str) -> tuple[int, int]:
    """Width and height of a size such as 640x384, multiples of 32.

    Raises:
        TrainingError: it is none.
    """
    match = re.fullmatch(r"(\d{1,4})x(\d{1,4})", text)
    size = (int(match[1]), int(match[2])) if match else (0, 0)
    if 0 in size or size[0] % 32 or size[1] % 32:
        raise TrainingError(f"{text!r} is no size: give width x height in multiples of 32, 640x384")
    return size


def network_size(width: float, depth: float) -> NetworkSize:
    """The lean network of this width and depth."""
    from dataclasses import replace

    from snapfit.models.detector.recipe import LEAN

    return replace(LEAN, width=width, depth=depth)


def rendered_images(
    console: Console, asset: Asset, data: Path, count: int, keypoints: int, seed: int, jobs: int
) -> TrainSet:
    """The training images, what is missing of them rendered first.

    Raises:
        DatasetError: the folder holds another set, or the disk is full.
    """
    from snapfit.models.train_reader import TrainSet
    from snapfit.models.workbench.train_set import TrainOrder

    order = TrainOrder(data, (str(asset.directory),), count=count, seed=seed, n_keypoints=keypoints)
    render_train_split(console, order, jobs, "loky")
    return TrainSet(data / asset.name)


def run_training(
    console: Console,
    asset: Asset,
    images: TrainSet,
    recipe: Recipe,
    out: Path,
    device: str,
    begin_from: Path | None,
    *,
    is_int8: bool,
) -> None:
    """Trains, writes the files, and says how good it became.

    Raises:
        TrainingError: there is no such device, or the checkpoint is of another recipe.
        DatasetError: an image cannot be read.
    """
    from snapfit.models.detector.train import train_detector

    place = _workplace(console, device)
    with _shown(console) as show:
        card = train_detector(
            asset,
            images,
            recipe,
            out,
            place,
            begin_from=begin_from,
            is_int8=is_int8,
            progress=show,
        )
    console.print(_figures(card))
    console.print(f"{out}: detector.onnx, detector.json, losses.png; checkpoint.pt to go on from")


def run_shared_training(
    console: Console,
    sets: Sequence[tuple[Asset, TrainSet]],
    recipe: Recipe,
    out: Path,
    device: str,
) -> None:
    """Trains one network on the parts of several assets.

    Raises:
        TrainingError, DatasetError: as `run_training`.
    """
    from snapfit.models.detector.train import train_shared

    place = _workplace(console, device)
    with _shown(console) as show:
        train_shared(sets, recipe, out, place, progress=show)
    console.print(f"{out}: checkpoint.pt for --begin-from, losses.png")


def _workplace(console: Console, device: str) -> Workplace:
    from snapfit.models.detector.device import workplace

    place = workplace(device)
    kind = "bfloat16 and float32" if place.is_mixed else "float32"
    console.print(f"training on {place.name} in {kind}")
    return place


@contextmanager
def _shown(console: Console) -> Iterator[Callable[[Report], None]]:
    """A progress bar; gives what is to be called after each step."""
    columns = (
        TextColumn("training"),
        BarColumn(),
        TextColumn("{task.description}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("", total=1.0)

        def show(report: Report) -> None:
            words = f"step {report.step}, loss {report.loss:.2f}, {report.images_per_second:.0f}/s"
            bar.update(task, completed=report.share, description=words)

        yield show


def _figures(card: DetectorCard) -> Table:
    table = Table("of the validation images", "")
    for name, value in card.metrics.items():
        table.add_row(name.replace("_", " "), f"{value:.4g}")
    table.add_row("minutes of training", f"{card.training['minutes']:.4g}")
    return table
