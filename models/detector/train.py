"""Trains the detector of an asset: images, training, checks, and the files of the bundle."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from snapfit.models.asset import Asset
from snapfit.models.detector.batches import Batch, Course, training_batches, whole_batches
from snapfit.models.detector.card import (
    CARD_NAME,
    INT8_NAME,
    ONNX_NAME,
    CardClass,
    DetectorCard,
    write_card,
)
from snapfit.models.detector.curves import write_curves
from snapfit.models.detector.device import Workplace
from snapfit.models.detector.export import export_onnx
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
    assembled = None if recipe.assembled else False
    samples = data.selected(validation=False, assembled=assembled)
    if not samples:
        raise DatasetError(out, "no training image is left: render more (--count)")
    shapes = part_shapes(asset, data.classes)
    course = Course(samples, shapes, recipe.views, recipe.seed)
    trainer = Trainer(recipe, len(data.classes), len(data.classes[0].keypoints_m), workplace)
    checkpoint = out / CHECKPOINT_NAME
    if checkpoint.is_file():
        trainer.resume(checkpoint)
    elif begin_from is not None:
        trainer.begin_from(begin_from)
    _train(trainer, course, checkpoint, progress)
    settle_statistics(trainer.averaged, _settling(trainer, course), workplace)
    write_checkpoint(trainer, checkpoint)
    write_curves(trainer.history, out / CURVES_NAME)
    whole = data.selected(validation=True)
    found = _validation(trainer, whole, shapes)
    card = _card(data, trainer, len(samples), found, begin_from)
    export_onnx(trainer.averaged, out / ONNX_NAME, metadata={"asset": data.asset})
    write_card(card, out / CARD_NAME)
    if is_int8:
        from snapfit.models.detector.quantise import write_int8

        batches = whole_batches(whole[:_CALIBRATION_IMAGES], shapes, recipe.whole, 1)
        write_int8(trainer.averaged, out / INT8_NAME, [(each / 255).numpy() for each, _ in batches])
    return card


def _train(trainer: Trainer, course: Course, checkpoint: Path, progress: Progress | None) -> None:
    """Learns until the recipe is done; the state is kept every minute, and when it is ended."""
    recipe = trainer.recipe
    begin, first, kept = time.perf_counter(), trainer.step, time.perf_counter()
    for images, targets in _batches(trainer, course, range(trainer.step, recipe.steps)):
        if trainer.progress >= 1:
            break
        values = trainer.learn(images, targets)
        now = time.perf_counter()
        if progress is not None:
            speed = (trainer.step - first) * recipe.batch / (now - begin)
            progress(Report(trainer.progress, trainer.step, values["total"], speed))
        if now - kept > _KEPT_EVERY_S:
            write_checkpoint(trainer, checkpoint)
            kept = now


def _settling(trainer: Trainer, course: Course) -> Iterator[Batch]:
    """Views that no step has seen."""
    steps = range(trainer.recipe.steps, trainer.recipe.steps + _SETTLING_BATCHES)
    return _batches(trainer, course, steps)


def _batches(trainer: Trainer, course: Course, steps: range) -> Iterator[Batch]:
    place = trainer.workplace
    pinned = place.device.type == "cuda"
    return training_batches(
        course, trainer.recipe.batch, steps, workers=place.workers, pinned=pinned
    )


def _validation(
    trainer: Trainer, samples: Sequence[TrainSample], shapes: dict[str, PartShape]
) -> Validation:
    few = list(itertools.islice(samples, _MOST_VALIDATED))
    batches = whole_batches(few, shapes, trainer.recipe.whole, _VALIDATION_BATCH)
    found: Validation = validated(trainer.averaged, batches, trainer.workplace.device)
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
