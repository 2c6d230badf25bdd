"""What the network is trained for: the loss of the GBOT paper, section 3.1, equation 1."""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
from torch import Tensor
from torch.nn import functional

from snapfit.models.detector.assigner import Assignment, assign
from snapfit.models.detector.boxes import complete_iou, scale
from snapfit.models.detector.network import RawOutput
from snapfit.models.detector.size import N_BINS
from snapfit.models.detector.targets import Targets

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
        return torch.stack([getattr(self, each.name) for each in fields(self)]).sum()

    def values(self) -> dict[str, float]:
        """Each as a number, and their sum."""
        names = [each.name for each in fields(self)]
        # All at once: each number that is asked for makes a GPU wait.
        numbers = torch.stack([getattr(self, name).detach() for name in names]).tolist()
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
    image, anchor = torch.nonzero(assignment.is_positive, as_tuple=True)
    part = assignment.part[image, anchor]
    quality = assignment.quality[image, anchor]
    true_boxes = targets.boxes[image, part]
    overlap = complete_iou(boxes[image, anchor], true_boxes)
    sides = _distribution_loss(raw, image, anchor, true_boxes)
    distance, presence = _keypoint_losses(raw, targets, (image, anchor, part))
    return Losses(
        classes=weights.classes * _varifocal(classes, raw.anchors, targets, assignment) / count,
        box=weights.box * ((1 - overlap) * quality).sum() / count,
        distribution=weights.distribution * (sides * quality).sum() / count,
        keypoints=weights.keypoints * (distance * quality).sum() / count,
        presence=weights.presence * (presence * quality).sum() / count,
    )


def _varifocal(logits: Tensor, anchors: Tensor, targets: Targets, assignment: Assignment) -> Tensor:
    """Zhang et al., "VarifocalNet", equation 2, summed over all anchors and classes."""
    wanted = torch.zeros_like(logits)
    image, anchor = torch.nonzero(assignment.is_positive, as_tuple=True)
    number = targets.classes[image, assignment.part[image, anchor]]
    wanted[image, anchor, number] = assignment.quality[image, anchor]
    is_positive = torch.zeros_like(logits)
    is_positive[image, anchor, number] = 1.0
    negative = _NEGATIVE_WEIGHT * logits.detach().sigmoid().pow(_NEGATIVE_FOCUS)
    negative = negative * ~_is_excused(logits, anchors, targets)
    weight = torch.where(is_positive > 0, wanted, negative)
    errors = functional.binary_cross_entropy_with_logits(logits, wanted, reduction="none")
    return (errors * weight).sum()


def _is_excused(logits: Tensor, anchors: Tensor, targets: Targets) -> Tensor:
    """(B, A, C) where a part that is hardly seen may be found or not."""
    excused = torch.zeros_like(logits, dtype=torch.bool)
    ignored = targets.is_ignored & (targets.classes >= 0)
    image, part = torch.nonzero(ignored, as_tuple=True)
    boxes = targets.boxes[image, part]
    inside = ((anchors > boxes[:, None, :2]) & (anchors < boxes[:, None, 2:])).all(-1)
    row, anchor = torch.nonzero(inside, as_tuple=True)
    excused[image[row], anchor, targets.classes[image[row], part[row]]] = True
    return excused


def _distribution_loss(raw: RawOutput, image: Tensor, anchor: Tensor, boxes: Tensor) -> Tensor:
    """(P,) mean over the sides: cross entropy with the two bins around the true distance.

    Li et al., "Generalized Focal Loss", NeurIPS 2020, equation 6.
    """
    anchors = raw.anchors[anchor]
    distances = torch.cat([anchors - boxes[:, :2], boxes[:, 2:] - anchors], dim=-1)
    distances = (distances / raw.strides[anchor, None]).clamp(0, N_BINS - 1.01)
    lower = distances.long()
    share = distances - lower
    logs = raw.sides[image, anchor].float().log_softmax(-1)
    below = logs.gather(-1, lower[..., None])[..., 0]
    above = logs.gather(-1, lower[..., None] + 1)[..., 0]
    return -(below * (1 - share) + above * share).mean(-1)


def _keypoint_losses(
    raw: RawOutput, targets: Targets, where: tuple[Tensor, Tensor, Tensor]
) -> tuple[Tensor, Tensor]:
    """(P,) mean distance of the keypoints in sizes of the part, and cross entropy of presence."""
    image, anchor, part = where
    true = targets.keypoints[image, part]
    size = scale(targets.boxes[image, part]).clamp(min=1.0)
    points = raw.points_at(image, anchor)
    offset = (points - true[..., :2]) / size[:, None, None]
    distance = (offset.square().sum(-1) + _SMOOTHING**2).sqrt() - _SMOOTHING
    is_present = true[..., 2]
    mean = (distance * is_present).sum(-1) / is_present.sum(-1).clamp(min=1)
    logits = raw.keypoints[image, anchor][..., 2].float()
    presence = functional.binary_cross_entropy_with_logits(logits, is_present, reduction="none")
    return mean, presence.mean(-1)
