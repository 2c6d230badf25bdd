"""Views cut out of images, many at a time, where the network is trained: resampled and relit."""

from __future__ import annotations

import torch
from torch import Tensor

from snapfit.models.detector.view_batch import ViewBatch
from snapfit.models.detector.views import PADDING, ViewParameters

_PIXELS_AT_ONCE = 6_000_000


def cut_out(memory: Tensor, rows: Tensor, size: tuple[int, int], views: ViewBatch) -> Tensor:
    """The pictures of T views, (T, 3, height, width) float32, 0 to 255, red first.

    Args:
        memory: (N, H * W) int32 images, a pixel in each: blue in the lowest byte, green, red.
        rows: (T,) which of them each view is of.
        size: width W and height H of the images.
        views: on the same device.
    """
    step = max(1, _PIXELS_AT_ONCE // (views.width * views.height))
    pieces = [
        _cut(memory, rows[i : i + step], size, views.matrices[i : i + step], views)
        for i in range(0, len(views), step)
    ]
    return torch.cat(pieces)


def _cut(
    memory: Tensor, rows: Tensor, size: tuple[int, int], matrices: Tensor, views: ViewBatch
) -> Tensor:
    """Bilinear; what lies beyond the image is grey."""
    width, height = size
    u, v = _sources(matrices, views.width, views.height)
    left, top = u.floor(), v.floor()
    share_u, share_v = u - left, v - top
    result = torch.full((3, *u.shape), float(PADDING), device=memory.device)
    flat = memory.flatten()
    for right in (0, 1):
        for below in (0, 1):
            column, row = left.long() + right, top.long() + below
            is_inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
            place = row.clamp(0, height - 1) * width + column.clamp(0, width - 1)
            pixels = flat[place + rows[:, None, None] * (width * height)]
            weight = share_u if right else 1 - share_u
            weight = weight * (share_v if below else 1 - share_v) * is_inside
            for channel, shift in enumerate((16, 8, 0)):
                value = (pixels >> shift) & 255
                result[channel].addcmul_(weight, value - float(PADDING))
    return result.transpose(0, 1)


def relit(pictures: Tensor, parameters: ViewParameters, generator: torch.Generator) -> Tensor:
    """Pictures (T, 3, H, W), 0 to 255, in another light each: brightness, tint, contrast."""
    count = len(pictures)

    def spread(deviation: float, channels: int) -> Tensor:
        drawn = torch.randn(count, channels, generator=generator, device=generator.device)
        return (deviation * drawn).exp()[..., None, None]

    gains = spread(parameters.gain, 1) * spread(parameters.tint, 3)
    contrast = spread(parameters.contrast, 1)
    return ((pictures * gains - 127.5) * contrast + 127.5).clamp(0, 255)


def _sources(matrices: Tensor, width: int, height: int) -> tuple[Tensor, Tensor]:
    """(T, height, width) where in the image each pixel of each view comes from, px."""
    inverse = _inverse(matrices[:, :, :2])
    shift = -(inverse @ matrices[:, :, 2:])[..., 0]
    device = matrices.device
    x = torch.arange(width, device=device, dtype=torch.float32) + 0.5
    y = torch.arange(height, device=device, dtype=torch.float32) + 0.5
    a = inverse[:, :, :, None, None]
    u = a[:, 0, 0] * x + a[:, 0, 1] * y[:, None] + shift[:, 0, None, None] - 0.5
    v = a[:, 1, 0] * x + a[:, 1, 1] * y[:, None] + shift[:, 1, None, None] - 0.5
    return u, v


def _inverse(matrices: Tensor) -> Tensor:
    """(T, 2, 2) of (T, 2, 2); unlike `torch.linalg.inv` it does not make a GPU wait."""
    a, b, c, d = matrices.flatten(1).unbind(-1)
    adjugate = torch.stack([d, -b, -c, a], dim=-1).unflatten(-1, (2, 2))
    return adjugate / (a * d - b * c)[:, None, None]
