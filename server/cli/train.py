"""`snapfit train`: images, training, and the files that a bundle needs, in one command."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from snapfit.server.cli.errors import clear_errors


def train(
    assets: Annotated[
        list[str],
        typer.Argument(
            help="Name of a bundled asset, or its folder. Several: one network on the parts of "
            "all, for others to begin from."
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of the result; training/ASSET if absent, training/shared."),
    ] = None,
    data: Annotated[
        Path, typer.Option(help="Dataset folder; images that are missing there are rendered.")
    ] = Path("dataset"),
    count: Annotated[int, typer.Option(min=40, help="Images of the training set.")] = 3000,
    keypoints: Annotated[int, typer.Option(min=6, max=200, help="Keypoints of a part.")] = 17,
    steps: Annotated[int, typer.Option(min=1, help="Batches to learn from at most.")] = 8000,
    minutes: Annotated[float, typer.Option(min=0, help="End after so long; 0: no limit.")] = 0.0,
    batch: Annotated[int, typer.Option(min=1, help="Views in a batch; a GPU wants 128.")] = 8,
    rate: Annotated[float, typer.Option(min=1e-6, help="Learning rate at its highest.")] = 2e-3,
    width: Annotated[float, typer.Option(min=0.05, max=1.5, help="Of YOLOv8's layers.")] = 0.25,
    depth: Annotated[float, typer.Option(min=0.05, max=1.5, help="Of YOLOv8's blocks.")] = 0.33,
    input_px: Annotated[
        str, typer.Option("--input", help="Width x height of the input, multiples of 32.")
    ] = "640x384",
    view_px: Annotated[
        str, typer.Option("--view", help="Width x height of the views that are learnt from.")
    ] = "384x256",
    assembled: Annotated[
        bool,
        typer.Option("--with-assembled/--without-assembled", help="Learn joined parts too."),
    ] = True,
    begin_from: Annotated[
        Path | None, typer.Option(help="Checkpoint whose weights to begin from.")
    ] = None,
    device: Annotated[
        str, typer.Option(help="auto: a GPU where there is one; cpu, cuda, cuda:1.")
    ] = "auto",
    seed: Annotated[int, typer.Option(min=0, help="Of images, first weights and views.")] = 20,
    int8: Annotated[bool, typer.Option("--int8", help="Write detector.int8.onnx too.")] = False,
    jobs: Annotated[int, typer.Option(help="Processes to render with; -1: one a core.")] = -1,
) -> None:
    """Train the network that finds an asset's parts; the same command goes on with it."""
    console = Console(highlight=False)
    with clear_errors(exit_code=1):
        from snapfit.server.cli.train_run import (
            network_size,
            pixels,
            rendered_images,
            require_libraries,
            run_shared_training,
            run_training,
        )

        require_libraries()
        from snapfit.models.asset import find_asset
        from snapfit.models.detector.recipe import Recipe
        from snapfit.models.detector.views import ViewParameters

        found = [find_asset(name) for name in assets]
        (input_width, input_height), (view_width, view_height) = pixels(input_px), pixels(view_px)
        recipe = Recipe(
            size=network_size(width, depth),
            views=ViewParameters(across_px=input_width, height_px=view_height, width_px=view_width),
            input_height_px=input_height,
            input_width_px=input_width,
            steps=steps,
            minutes=minutes,
            batch=batch,
            learning_rate=rate,
            assembled=assembled,
            seed=seed,
        )
        folder = data.absolute()
        sets = [
            (each, rendered_images(console, each, folder, count, keypoints, seed, jobs))
            for each in found
        ]
        if len(sets) > 1:
            run_shared_training(console, sets, recipe, out or Path("training/shared"), device)
            return
        ((only, images),) = sets
        out = out or Path("training") / only.name
        run_training(console, only, images, recipe, out, device, begin_from, is_int8=int8)
