"""Boxes in PyTorch: left, top, right, bottom (px), and how well two of them agree."""

from __future__ import annotations

import math

import torch
from torch import Tensor

_EPSILON = 1e-7


def iou(a: Tensor, b: Tensor) -> Tensor:
    """Intersection over union of boxes (..., 4) with boxes (..., 4); shapes broadcast."""
    near = torch.maximum(a[..., :2], b[..., :2])
    far = torch.minimum(a[..., 2:], b[..., 2:])
    common = _product((far - near).clamp(min=0))
    return common / (area(a) + area(b) - common + _EPSILON)


def complete_iou(a: Tensor, b: Tensor) -> Tensor:
    """IoU less penalties for distance and shape (Zheng et al., "Distance-IoU Loss", AAAI 2020).

    Shapes broadcast; 1 where the boxes are the same, below 0 where they lie apart.
    """
    overlap = iou(a, b)
    hull = torch.maximum(a[..., 2:], b[..., 2:]) - torch.minimum(a[..., :2], b[..., :2])
    diagonal = hull.square().sum(-1) + _EPSILON
    between = (a[..., :2] + a[..., 2:] - b[..., :2] - b[..., 2:]).square().sum(-1) / 4
    shape = (4 / math.pi**2) * (_slope(a) - _slope(b)).square()
    # The weight is a constant in the gradient, as published.
    with torch.no_grad():
        weight = shape / (1 - overlap + shape + _EPSILON)
    return overlap - between / diagonal - weight * shape


def area(boxes: Tensor) -> Tensor:
    """(...) px squared, of boxes (..., 4)."""
    return _product((boxes[..., 2:] - boxes[..., :2]).clamp(min=0))


def scale(boxes: Tensor) -> Tensor:
    """(...) px: how large an object is, by its box (..., 4); the side of a square."""
    sides = boxes[..., 2:] - boxes[..., :2]
    return sides.square().mean(-1).sqrt()


def _slope(boxes: Tensor) -> Tensor:
    """Angle of a box's diagonal, rad."""
    sides = (boxes[..., 2:] - boxes[..., :2]).clamp(min=_EPSILON)
    return torch.atan2(sides[..., 0], sides[..., 1])


def _product(sides: Tensor) -> Tensor:
    """(...) of (..., 2); the gradient of `torch.prod` makes a GPU wait, as it looks for zeros."""
    return sides[..., 0] * sides[..., 1]
