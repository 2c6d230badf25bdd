"""How large a network is: widths and depths of YOLOv8's family, and of smaller ones."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

STRIDES = (8, 16, 32)
N_BINS = 16
"""Bins of a distance from an anchor to a side of its box (distribution focal loss)."""

_CHANNELS = (64, 128, 256, 512, 1024)
_REPEATS = (3, 6, 6, 3)


@dataclass(frozen=True)
class NetworkSize:
    """The free numbers of the architecture; the defaults are those of YOLOv8n-pose.

    Attributes:
        width: share of the family's full widths (64 to 1024 channels).
        depth: share of the family's full number of bottlenecks.
        most_channels: no layer of the backbone is wider, before `width` is applied.
        box_channels, class_channels, keypoint_channels: of the two hidden layers of each head.

    Raises:
        ValueError: a number that is not positive.
    """

    width: float = 0.25
    depth: float = 1 / 3
    most_channels: int = 1024
    box_channels: int = 64
    class_channels: int = 64
    keypoint_channels: int = 51

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if not value > 0:
                raise ValueError(f"{name} of a network is positive, this is {value}")

    @property
    def channels(self) -> tuple[int, ...]:
        """Channels after each of the five halvings of the image's size, multiples of 8."""
        return tuple(
            max(8, round(min(full, self.most_channels) * self.width / 8) * 8) for full in _CHANNELS
        )

    @property
    def repeats(self) -> tuple[int, ...]:
        """Bottlenecks in the C2f block after the second to the fifth halving."""
        return tuple(max(1, round(full * self.depth)) for full in _REPEATS)

    def to_json(self) -> dict[str, Any]:
        """As it stands in a checkpoint and in `detector.json`."""
        return asdict(self)


YOLOV8N = NetworkSize()
"""The public YOLOv8n-pose, with which speed is compared."""
