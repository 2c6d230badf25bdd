"""How a network is trained: all numbers that make one training differ from another."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields
from typing import Any

from snapfit.models.detector.losses import LossWeights
from snapfit.models.detector.size import STRIDES, NetworkSize
from snapfit.models.detector.views import ViewParameters

LEAN = NetworkSize(most_channels=512, box_channels=32, class_channels=32, keypoint_channels=48)
"""YOLOv8n with narrower heads and a narrower last stage: parts on a bench are seldom large."""


@dataclass(frozen=True)
class Recipe:
    """How a network is trained.

    Attributes:
        size: of the network.
        views: of the training images.
        input_height_px, input_width_px: of the input that it is validated at and meant for.
        steps: batches to train on.
        minutes: end after so much time at the latest, and let the learning rate fall by then;
            0 for no limit.
        batch: views in each.
        learning_rate: at its highest.
        weight_decay: of weights; none of biases and normalisation.
        warm_up: share of the training in which the learning rate rises.
        final_rate: share of the highest learning rate that is left in the end.
        average: how slowly the averaged network follows (0 to 1).
        clip: largest length of the gradient.
        assembled: whether images with joined parts are learnt from.
        seed: of first weights, order and views.
        weights: of the losses.

    Raises:
        ValueError: a number that cannot be.
    """

    size: NetworkSize = LEAN
    views: ViewParameters = field(default_factory=ViewParameters)
    input_height_px: int = 384
    input_width_px: int = 640
    steps: int = 8000
    minutes: float = 0.0
    batch: int = 8
    learning_rate: float = 2e-3
    weight_decay: float = 0.05
    warm_up: float = 0.05
    final_rate: float = 0.01
    average: float = 0.998
    clip: float = 10.0
    assembled: bool = True
    seed: int = 0
    weights: LossWeights = field(default_factory=LossWeights)

    def __post_init__(self) -> None:
        sizes = (
            self.input_height_px,
            self.input_width_px,
            self.views.height_px,
            self.views.width_px,
        )
        if any(size <= 0 or size % STRIDES[-1] for size in sizes):
            raise ValueError(f"a network's input is a multiple of 32 pixels, this is {sizes}")
        may_be_zero = ("minutes", "seed", "weight_decay", "average")
        for each in fields(self):
            value = getattr(self, each.name)
            if not isinstance(value, int | float) or isinstance(value, bool):
                continue
            if value < 0 or (value == 0 and each.name not in may_be_zero):
                raise ValueError(f"{each.name} of a training is positive, this is {value}")

    @property
    def whole(self) -> ViewParameters:
        """The view of a whole image in which the network is validated."""
        return ViewParameters(
            height_px=self.input_height_px, width_px=self.input_width_px, zoom=1.0, roll_deg=0.0
        )

    def to_json(self) -> dict[str, Any]:
        """As it stands in a checkpoint and in `detector.json`."""
        return asdict(self)
