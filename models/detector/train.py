"""Trains the detector of an asset: images, training, checks, and the files of the bundle."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from snapfit.models.asset import Asset
from snapfit.models.detector.batches import Course, whole_batches
from snapfit.models.detector.card import (
    CARD_NAME,
    INT8_NAME,
    ONNX_NAME,
    CardClass,
    DetectorCard,
    write_card,
)
from snapfit.models.detector.curves import write_curves
from snapfit.models.detector.device import CPU, Workplace
from snapfit.models.detector.export import export_onnx
from snapfit.models.detector.graphed import GraphedSteps
from snapfit.models.detector.label_table import Group
from snapfit.models.detector.metrics import Validation, validated
from snapfit.models.detector.onnx_graph import OPSET
from snapfit.models.detector.recipe import Recipe
from snapfit.models.detector.shapes import PartShape, part_shapes
from snapfit.models.detector.trainer import Trainer, settle_statistics, write_checkpoint
from snapfit.models.errors import DatasetError
from snapfit.models.train_reader import TrainSample, TrainSet

CHECKPOINT_NAME, CURVES_NAME = "checkpoint.pt", "losses.png"
_SETTLING_BATCHES = 40
_KEPT_EVERY_S = 60.0
_MOST_VALIDATED = 400
_VALIDATION_BATCH = 8
_CALIBRATION_IMAGES = 32


@dataclass(frozen=True)
class Report:
    """How far a training is.

    Attributes:
        share: done, 0 to 1.
        step: batches learnt from.
        loss: total of the last step.
        images_per_second: of this run.
    """

    share: float
    step: int
    loss: float
    images_per_second: float


Progress = Callable[[Report], None]


def train_detector(
    asset: Asset,
    data: TrainSet,
    recipe: Recipe,
    out: Path,
    workplace: Workplace,
    *,
    begin_from: Path | None = None,
    is_int8: bool = False,
    progress: Progress | None = None,
) -> DetectorCard:
    """Trains a network, or goes on with a training, and writes what a bundle needs.

    `out` gets `detector.onnx`, `detector.json`, `losses.png` and `checkpoint.pt`.

    Args:
        asset: whose parts are to be found.
        data: its training images.
        recipe: how it is trained.
        out: folder; a checkpoint of the same recipe there is gone on with.
        workplace: where it is trained.
        begin_from: checkpoint of another training whose weights are taken over where they fit.
        is_int8: whether to write `detector.int8.onnx` too.
        progress: called after each step.

    Raises:
        TrainingError: the checkpoint is of another recipe, or the loss is no number.
        DatasetError: an image is missing, or none is left to train on.
    """
    shapes = part_shapes(asset, data.classes)
    groups = [(_selected(data, recipe, out), shapes)]
    trainer = _learnt(groups, recipe, out, workplace, begin_from, progress)
    whole = data.selected(validation=True)[:_MOST_VALIDATED]
    found = _validation(trainer, whole, shapes)
    card = _card(data, trainer, len(groups[0][0]), found, begin_from)
    export_onnx(trainer.averaged, out / ONNX_NAME, metadata={"asset": data.asset})
    write_card(card, out / CARD_NAME)
    if is_int8:
        from snapfit.models.detector.quantise import write_int8

        few = [(whole[:_CALIBRATION_IMAGES], shapes)]
        batches = whole_batches(few, recipe.whole, 1, CPU)
        write_int8(trainer.averaged, out / INT8_NAME, [(each / 255).numpy() for each, _ in batches])
    return card


def train_shared(
    sets: Sequence[tuple[Asset, TrainSet]],
    recipe: Recipe,
    out: Path,
    workplace: Workplace,
    *,
    progress: Progress | None = None,
) -> None:
    """Trains one network on the parts of several assets: weights for others to begin from.

    `out` gets `checkpoint.pt` and `losses.png`. The arguments are those of `train_detector`.

    Raises:
        TrainingError, DatasetError: as `train_detector`.
    """
    groups: list[Group] = []
    for asset, data in sets:
        first = sum(len(known) for _, known in groups)
        shapes = part_shapes(asset, data.classes, first)
        groups.append((_selected(data, recipe, out), shapes))
    _learnt(groups, recipe, out, workplace, None, progress)


def _selected(data: TrainSet, recipe: Recipe, out: Path) -> list[TrainSample]:
    samples = data.selected(validation=False, assembled=None if recipe.assembled else False)
    if not samples:
        raise DatasetError(out, "no training image is left: render more (--count)")
    return samples


def _learnt(
    groups: Sequence[Group],
    recipe: Recipe,
    out: Path,
    workplace: Workplace,
    begin_from: Path | None,
    progress: Progress | None,
) -> Trainer:
    """A trainer at the end of its recipe; its checkpoint and its curves are written."""
    shapes = [shape for _, known in groups for shape in known.values()]
    trainer = Trainer(recipe, len(shapes), len(shapes[0].keypoints_m), workplace)
    checkpoint = out / CHECKPOINT_NAME
    if checkpoint.is_file():
        trainer.resume(checkpoint)
    elif begin_from is not None:
        trainer.begin_from(begin_from)
    course = Course(groups, recipe.views, recipe.seed, workplace)
    _train(trainer, course, checkpoint, progress)
    # Views that no step has seen.
    steps = range(recipe.steps, recipe.steps + _SETTLING_BATCHES)
    settle_statistics(trainer.averaged, course.batches(recipe.batch, steps), workplace)
    write_checkpoint(trainer, checkpoint)
    write_curves(trainer.history, out / CURVES_NAME)
    return trainer


def _train(trainer: Trainer, course: Course, checkpoint: Path, progress: Progress | None) -> None:
    """Learns until the recipe is done; the state is kept every minute, and when it is ended."""
    recipe = trainer.recipe
    before_s, first = trainer.elapsed_s, trainer.step
    begin = kept = time.perf_counter()
    for loss in _steps(trainer, course):
        now = time.perf_counter()
        trainer.elapsed_s = before_s + now - begin
        if progress is not None:
            speed = (trainer.step - first) * recipe.batch / (now - begin)
            progress(Report(trainer.progress, trainer.step, loss, speed))
        if now - kept > _KEPT_EVERY_S:
            write_checkpoint(trainer, checkpoint)
            kept = now


def _steps(trainer: Trainer, course: Course) -> Iterator[float]:
    """Makes the steps that are left; gives the last known loss after each."""
    recipe = trainer.recipe
    if course.memory is not None:
        graphed = GraphedSteps(trainer, course, course.memory)
        while trainer.step < recipe.steps and trainer.progress < 1:
            graphed.learn()
            yield trainer.history["total"][-1] if trainer.history else float("nan")
        graphed.read()
        return
    for images, targets in course.batches(recipe.batch, range(trainer.step, recipe.steps)):
        if trainer.progress >= 1:
            return
        yield trainer.learn(images, targets)["total"]


def _validation(
    trainer: Trainer, samples: Sequence[TrainSample], shapes: dict[str, PartShape]
) -> Validation:
    place = trainer.workplace
    batches = whole_batches([(samples, shapes)], trainer.recipe.whole, _VALIDATION_BATCH, place)
    found: Validation = validated(trainer.averaged, batches, place.device)
    return found


def _card(
    data: TrainSet,
    trainer: Trainer,
    n_images: int,
    found: Validation,
    begin_from: Path | None,
) -> DetectorCard:
    recipe = trainer.recipe
    training: dict[str, Any] = {
        "images": n_images,
        "images_with_joined_parts": recipe.assembled,
        "views": trainer.step * recipe.batch,
        "minutes": round(trainer.elapsed_s / 60, 1),
        "machine": trainer.workplace.name,
        "precision": "bfloat16 and float32" if trainer.workplace.is_mixed else "float32",
        "began_from": begin_from.name if begin_from else None,
        "pytorch": torch.__version__,
        "parameters": sum(each.numel() for each in trainer.averaged.parameters()),
        "recipe": recipe.to_json(),
    }
    return DetectorCard(
        asset=data.asset,
        classes=tuple(
            CardClass(part=each.part, keypoints_m=each.keypoints_m.tolist())
            for each in data.classes
        ),
        input_height_px=recipe.input_height_px,
        input_width_px=recipe.input_width_px,
        opset=OPSET,
        training=training,
        metrics=found.to_json(),
    )
