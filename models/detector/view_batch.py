"""Views of training images drawn at random, many at a time, and what is true in them.

A mirrored part is another part: views are turned and scaled, never mirrored. Turning the picture
about the principal point is the same as rolling the camera; a symmetric part's canonical pose, and
with it its keypoints, is found anew for the rolled camera.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from snapfit.models.detector.boxes import area
from snapfit.models.detector.label_table import LabelTable
from snapfit.models.detector.shape_table import ShapeTable, canonical
from snapfit.models.detector.targets import Targets
from snapfit.models.detector.views import ViewParameters

# Of a part that the view cuts off, so much of its box must be inside.
LEAST_INSIDE = 0.3
_NEAREST_M = 1e-3


@dataclass(frozen=True, eq=False)
class ViewBatch:
    """T cut-outs of one size.

    Attributes:
        images: (T,) which image of the table each shows.
        matrices: (T, 2, 3) view from image, px, edges at 0.
        rolls: (T,) rad, by which the camera is rolled, so that content turns from x to y.
        width, height: px.
    """

    images: Tensor
    matrices: Tensor
    rolls: Tensor
    width: int
    height: int

    def __len__(self) -> int:
        return len(self.images)


def sampled_views(
    table: LabelTable,
    images: Tensor,
    aims: Tensor,
    size: tuple[int, int],
    parameters: ViewParameters,
    aimed_share: float,
    generator: torch.Generator,
) -> ViewBatch:
    """Views at random.

    Args:
        table: of the images.
        images: (T,) which image each view is of.
        aims: (T, 4) left, top, right, bottom of the part that lies somewhere in the view, px; an
            empty box (right = left) for any place.
        size: width and height of the views, px.
        parameters: what a view is like.
        aimed_share: share of the views that are laid around their part.
        generator: where chance comes from, on the device of the table.
    """
    count, (width, height) = len(images), size
    wide, high = table.size
    device = generator.device

    def uniform(*shape: int) -> Tensor:
        return torch.rand(shape, generator=generator, device=device)

    scale = parameters.across_px / wide * parameters.zoom ** (2 * uniform(count) - 1)
    sides = (aims[:, 2:] - aims[:, :2]).amax(dim=1)
    is_aimed = (sides > 0) & (uniform(count) < aimed_share)
    # A part that is larger than the view is made to fit, nearly.
    fitting = torch.minimum(scale, 1.1 * min(width, height) / sides.clamp(min=1))
    scale = torch.where(is_aimed, fitting, scale)
    whole = filled(device, wide, high)
    anywhere = uniform(count, 2) * whole
    aim = torch.where(is_aimed[:, None], (aims[:, :2] + aims[:, 2:]) / 2, anywhere)
    roll = math.radians(parameters.roll_deg) * torch.randn(
        count, generator=generator, device=device
    )
    turn = scale[:, None, None] * _turns(roll)
    extent = filled(device, width, height)
    border = parameters.border_share
    goal = (border + (1 - 2 * border) * uniform(count, 2)) * extent
    offset = goal - (turn @ (aim + 0.5)[..., None])[..., 0]
    # What lies beyond the image teaches nothing: leave little of it in the view.
    wished = (turn @ (whole / 2)[:, None])[..., 0] + offset - extent / 2
    slack = (scale[:, None] * whole - extent).abs() / 2 + 0.06 * extent
    offset = offset + wished.clamp(-slack, slack) - wished
    return ViewBatch(images, torch.cat([turn, offset[..., None]], dim=-1), roll, width, height)


def labelled(views: ViewBatch, table: LabelTable, shapes: ShapeTable) -> Targets:
    """What is true in views: T of them, M parts each as in the table; those outside are -1."""
    images = views.images
    camera, matrices = table.cameras[images], views.matrices
    classes = table.classes[images]
    kinds = classes.clamp(min=0)
    rolled = torch.stack([views.rolls.cos(), views.rolls.sin()], dim=-1)
    rotations, translations = _rolled_canonical(
        table.rotations[images], table.translations[images], kinds, rolled, shapes
    )
    outline = _places(shapes.hulls[kinds], rotations, translations, camera, matrices)
    keypoints = _places(shapes.keypoints[kinds], rotations, translations, camera, matrices)
    size = filled(images.device, views.width, views.height)
    near, far = outline.amin(dim=2), outline.amax(dim=2)
    box = torch.cat([near.clamp(min=0).minimum(size), far.clamp(min=0).minimum(size)], dim=-1)
    inside = area(box) / area(torch.cat([near, far], dim=-1)).clamp(min=1e-9)
    presence = ((keypoints >= 0) & (keypoints <= size)).all(dim=-1)
    return Targets(
        classes=torch.where(inside > 0, classes, -1),
        boxes=box,
        keypoints=torch.cat([keypoints, presence[..., None]], dim=-1),
        is_ignored=~table.is_seen[images] | (inside < LEAST_INSIDE),
    )


def _rolled_canonical(
    rotations: Tensor, translations: Tensor, kinds: Tensor, rolled: Tensor, shapes: ShapeTable
) -> tuple[Tensor, Tensor]:
    """In the frame of the camera as it was: the poses that are canonical in the rolled camera."""
    count, most = kinds.shape
    cosine, sine = rolled.unbind(-1)
    zero, one = torch.zeros_like(cosine), torch.ones_like(cosine)
    rows = [cosine, -sine, zero, sine, cosine, zero, zero, zero, one]
    turn = torch.stack(rows, dim=-1).unflatten(-1, (3, 3))[:, None]
    there = (turn @ rotations).flatten(0, 1), (turn @ translations[..., None]).flatten(0, 1)[..., 0]
    found_r, found_t = canonical(*there, kinds.flatten(), shapes)
    back = turn.transpose(-2, -1)
    found_r, found_t = found_r.unflatten(0, (count, most)), found_t.unflatten(0, (count, most))
    return back @ found_r, (back @ found_t[..., None])[..., 0]


def _places(
    points: Tensor, rotations: Tensor, translations: Tensor, cameras: Tensor, matrices: Tensor
) -> Tensor:
    """(T, M, P, 2) where points (T, M, P, 3) of bodies are in the views, px, edges at 0."""
    seen = points @ rotations.transpose(-2, -1) + translations[:, :, None]
    flat = seen[..., :2] / seen[..., 2:].clamp(min=_NEAREST_M)
    focal, middle = cameras[:, None, None, :2], cameras[:, None, None, 2:]
    pixels = flat * focal + middle + 0.5
    turn, shift = matrices[:, None, :, :2], matrices[:, None, None, :, 2]
    return pixels @ turn.transpose(-2, -1) + shift


def filled(device: torch.device, *numbers: float) -> Tensor:
    """(n,) numbers, written where they are needed: a CUDA graph copies nothing from elsewhere."""
    return torch.stack([torch.full((), float(number), device=device) for number in numbers])


def _turns(angles: Tensor) -> Tensor:
    """(T, 2, 2) of (T,) rad."""
    cosine, sine = angles.cos(), angles.sin()
    return torch.stack([cosine, -sine, sine, cosine], dim=-1).unflatten(-1, (2, 2))
