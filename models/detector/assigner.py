"""Which anchors have to find which part: the task-aligned assignment of TOOD.

Feng et al., "TOOD: Task-aligned One-stage Object Detection", ICCV 2021, section 3.2: the anchors
inside of a box whose class score and overlap are highest together are its positives, and their
class target is the larger the better they agree.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from snapfit.models.detector.boxes import complete_iou
from snapfit.models.detector.targets import Targets

_SCORE_POWER, _OVERLAP_POWER = 0.5, 6.0
POSITIVES = 10
"""Anchors of a part."""
# A box narrower than the finest cell may lie between all anchors: it is widened to reach one.
_LEAST_HALF_SIDE_PX = 4.5
_EPSILON = 1e-9


@dataclass(frozen=True, eq=False)
class Assignment:
    """What each of A anchors of B images has to say.

    Attributes:
        part: (B, A) int64 place of the part in `Targets`; 0 where there is none.
        is_positive: (B, A) whether there is one.
        quality: (B, A) 0 to 1: the class score that is wanted; 0 where there is none.
    """

    part: Tensor
    is_positive: Tensor
    quality: Tensor


@torch.no_grad()
def assign(scores: Tensor, boxes: Tensor, anchors: Tensor, targets: Targets) -> Assignment:
    """Gives each part its anchors.

    Args:
        scores: (B, A, C) 0 to 1, of the network as it is now.
        boxes: (B, A, 4) px, likewise.
        anchors: (A, 2) px.
        targets: M parts an image.
    """
    wanted = targets.is_wanted[..., None]
    index = targets.classes.clamp(min=0)[..., None].expand(-1, -1, scores.shape[1])
    score = scores.transpose(1, 2).gather(1, index)
    overlap = complete_iou(boxes[:, None], targets.boxes[:, :, None]).clamp(min=0)
    inside = _inside(anchors, targets.boxes) & wanted
    alignment = score.pow(_SCORE_POWER) * overlap.pow(_OVERLAP_POWER) * inside
    chosen = _best(alignment + _EPSILON * inside, inside)
    # An anchor that several parts want goes to the one it overlaps most.
    rival = torch.where(chosen, overlap + _EPSILON, torch.zeros_like(overlap))
    most, part = rival.max(dim=1)
    is_positive = most > 0
    owner = torch.zeros_like(chosen).scatter_(1, part[:, None], is_positive[:, None])
    return Assignment(part, is_positive, _quality(alignment, overlap, owner))


def _inside(anchors: Tensor, boxes: Tensor) -> Tensor:
    """(B, M, A) whether an anchor lies in a box."""
    center = (boxes[..., :2] + boxes[..., 2:]) / 2
    half = ((boxes[..., 2:] - boxes[..., :2]) / 2).clamp(min=_LEAST_HALF_SIDE_PX)
    return ((anchors - center[:, :, None]).abs() < half[:, :, None]).all(dim=-1)


def _best(alignment: Tensor, inside: Tensor) -> Tensor:
    """(B, M, A) whether an anchor is among the best of a part."""
    count = min(POSITIVES, alignment.shape[-1])
    places = alignment.topk(count, dim=-1).indices
    chosen = torch.zeros_like(inside).scatter_(-1, places, torch.ones_like(places, dtype=bool))
    return chosen & inside


def _quality(alignment: Tensor, overlap: Tensor, owner: Tensor) -> Tensor:
    """(B, A) alignment, scaled so that a part's best anchor has the part's best overlap."""
    alignment, overlap = alignment * owner, overlap * owner
    best_alignment = alignment.amax(dim=-1, keepdim=True)
    best_overlap = overlap.amax(dim=-1, keepdim=True)
    return (alignment * best_overlap / (best_alignment + _EPSILON)).amax(dim=1)
