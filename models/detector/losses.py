"""What the network is trained for: the loss of the GBOT paper, section 3.1, equation 1."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import torch
from torch import Tensor
from torch.nn import functional

from snapfit.models.detector.assigner import POSITIVES, Assignment, assign
from snapfit.models.detector.boxes import complete_iou, scale
from snapfit.models.detector.network import RawOutput
from snapfit.models.detector.size import N_BINS
from snapfit.models.detector.targets import Targets, at

# Varifocal loss (Zhang et al., CVPR 2021): weight and focus of what is no part.
_NEGATIVE_WEIGHT, _NEGATIVE_FOCUS = 0.75, 2.0
# Keeps the slope of a distance finite where it is zero; share of the part's size.
_SMOOTHING = 1e-3


@dataclass(frozen=True)
class LossWeights:
    """The weights of the losses, as the paper has them."""

    classes: float = 0.5
    box: float = 7.5
    distribution: float = 1.5
    keypoints: float = 12.0
    presence: float = 1.0


@dataclass(frozen=True, eq=False)
class Losses:
    """The losses of a batch, each weighted; scalars.

    Attributes:
        classes: varifocal, of the class scores.
        box: 1 - CIoU.
        distribution: distribution focal loss of the box's sides.
        keypoints: mean distance of the keypoints, in sizes of the part (L2).
        presence: cross entropy of whether a keypoint is in the image.
    """

    classes: Tensor
    box: Tensor
    distribution: Tensor
    keypoints: Tensor
    presence: Tensor

    @property
    def total(self) -> Tensor:
        """Their sum."""
        return self.stacked.sum()

    @property
    def stacked(self) -> Tensor:
        """(5,) in their order: each number that is asked for alone makes a GPU wait."""
        return torch.stack([getattr(self, each.name) for each in fields(self)])

    def values(self) -> dict[str, float]:
        """Each as a number, and their sum."""
        return named(self.stacked.detach().tolist())


def named(numbers: Sequence[float]) -> dict[str, float]:
    """Losses in their order by name, and their sum."""
    names = [each.name for each in fields(Losses)]
    return {**dict(zip(names, numbers, strict=True)), "total": sum(numbers)}


def losses(raw: RawOutput, targets: Targets, weights: LossWeights | None = None) -> Losses:
    """How wrong the network is.

    Args:
        raw: what it says of B images.
        targets: what is true.
        weights: of the losses; the paper's if absent.
    """
    weights = weights or LossWeights()
    classes, boxes = raw.classes.float(), raw.boxes()
    assignment = assign(classes.detach().sigmoid(), boxes.detach(), raw.anchors, targets)
    count = assignment.quality.sum().clamp(min=1.0)
    anchor, part, quality = _positives(assignment, targets.classes.shape[1])
    true_boxes = at(targets.boxes, part)
    overlap = complete_iou(at(boxes, anchor), true_boxes)
    sides = _distribution_loss(raw, anchor, true_boxes)
    distance, presence = _keypoint_losses(raw, anchor, true_boxes, at(targets.keypoints, part))
    return Losses(
        classes=weights.classes * _varifocal(classes, raw.anchors, targets, assignment) / count,
        box=weights.box * ((1 - overlap) * quality).sum() / count,
        distribution=weights.distribution * (sides * quality).sum() / count,
        keypoints=weights.keypoints * (distance * quality).sum() / count,
        presence=weights.presence * (presence * quality).sum() / count,
    )


def _positives(assignment: Assignment, most: int) -> tuple[Tensor, Tensor, Tensor]:
    """(B, P) anchor, part and quality of all positives; those that fill up have quality 0.

    Their number is fixed by that of the parts: no step asks the device how many there are.
    """
    count = min(POSITIVES * most, assignment.part.shape[1])
    wanted = assignment.quality + assignment.is_positive
    anchor = wanted.topk(count, dim=1).indices
    return anchor, at(assignment.part, anchor), at(assignment.quality, anchor)


def _varifocal(logits: Tensor, anchors: Tensor, targets: Targets, assignment: Assignment) -> Tensor:
    """Zhang et al., "VarifocalNet", equation 2, summed over all anchors and classes."""
    number = at(targets.classes, assignment.part)
    is_positive = _one_hot(number, logits.shape[-1]) & assignment.is_positive[..., None]
    wanted = is_positive * assignment.quality[..., None]
    negative = _NEGATIVE_WEIGHT * logits.detach().sigmoid().pow(_NEGATIVE_FOCUS)
    negative = negative * ~_is_excused(logits, anchors, targets)
    weight = torch.where(is_positive, wanted, negative)
    errors = functional.binary_cross_entropy_with_logits(logits, wanted, reduction="none")
    return (errors * weight).sum()


def _is_excused(logits: Tensor, anchors: Tensor, targets: Targets) -> Tensor:
    """(B, A, C) where a part that is hardly seen may be found or not."""
    boxes = targets.boxes[:, None]
    places = anchors[:, None]
    inside = ((places > boxes[..., :2]) & (places < boxes[..., 2:])).all(-1)
    ignored = _one_hot(targets.classes, logits.shape[-1]) & targets.is_ignored[..., None]
    return inside.to(logits.dtype) @ ignored.to(logits.dtype) > 0


def _one_hot(numbers: Tensor, count: int) -> Tensor:
    """(..., count) bool; none where a number is -1."""
    return numbers[..., None] == torch.arange(count, device=numbers.device)


def _distribution_loss(raw: RawOutput, anchor: Tensor, boxes: Tensor) -> Tensor:
    """(B, P) mean over the sides: cross entropy with the two bins around the true distance.

    Li et al., "Generalized Focal Loss", NeurIPS 2020, equation 6.
    """
    anchors = raw.anchors[anchor]
    distances = torch.cat([anchors - boxes[..., :2], boxes[..., 2:] - anchors], dim=-1)
    distances = (distances / raw.strides[anchor][..., None]).clamp(0, N_BINS - 1.01)
    lower = distances.long()
    share = distances - lower
    logs = at(raw.sides, anchor).float().log_softmax(-1)
    below = logs.gather(-1, lower[..., None])[..., 0]
    above = logs.gather(-1, lower[..., None] + 1)[..., 0]
    return -(below * (1 - share) + above * share).mean(-1)


def _keypoint_losses(
    raw: RawOutput, anchor: Tensor, boxes: Tensor, true: Tensor
) -> tuple[Tensor, Tensor]:
    """(B, P) mean distance of the keypoints in sizes of the part, and cross entropy of presence."""
    size = scale(boxes).clamp(min=1.0)
    said = at(raw.keypoints, anchor)
    offset = (raw.placed(said, anchor) - true[..., :2]) / size[..., None, None]
    distance = (offset.square().sum(-1) + _SMOOTHING**2).sqrt() - _SMOOTHING
    is_present = true[..., 2]
    mean = (distance * is_present).sum(-1) / is_present.sum(-1).clamp(min=1)
    presence = functional.binary_cross_entropy_with_logits(
        said[..., 2].float(), is_present, reduction="none"
    )
    return mean, presence.mean(-1)
