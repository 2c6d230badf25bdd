"""YOLOv8-pose's network: CSPDarknet, a path aggregation neck, three heads without anchor boxes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from snapfit.models.detector.blocks import C2f, ConvBlock, HeadBranch, Sppf
from snapfit.models.detector.size import N_BINS, STRIDES, NetworkSize

KEYPOINT_GAIN = 2.0
"""Strides by which a keypoint moves when the network's output grows by one."""

_CELLS_PER_OBJECT = 5.0


@dataclass(frozen=True, eq=False)
class RawOutput:
    """What the network says at each of A anchors of B images, before it is decoded.

    Attributes:
        sides: (B, A, 4, 16) logits of the distances to left, top, right, bottom, in strides.
        classes: (B, A, C) logits.
        keypoints: (B, A, K, 3) offsets from the anchor (`KEYPOINT_GAIN` strides), and the logit of
            their being in the image.
        anchors: (A, 2) their places, px of the input, the image's left edge is 0.
        strides: (A,) px.
    """

    sides: Tensor
    classes: Tensor
    keypoints: Tensor
    anchors: Tensor
    strides: Tensor

    def boxes(self) -> Tensor:
        """(B, A, 4) left, top, right, bottom, px."""
        bins = torch.arange(N_BINS, dtype=torch.float32, device=self.sides.device)
        distances = (self.sides.float().softmax(-1) * bins).sum(-1) * self.strides[:, None]
        near, far = distances.split(2, dim=-1)
        return torch.cat([self.anchors - near, self.anchors + far], dim=-1)

    def points(self) -> Tensor:
        """(B, A, K, 2) keypoints, px."""
        reach = KEYPOINT_GAIN * self.strides[:, None, None]
        return self.anchors[:, None] + self.keypoints[..., :2].float() * reach

    def points_at(self, image: Tensor, anchor: Tensor) -> Tensor:
        """(P, K, 2) keypoints, px, of P anchors by their image and their place in it."""
        return self.placed(self.keypoints[image, anchor], anchor)

    def placed(self, said: Tensor, anchor: Tensor) -> Tensor:
        """(..., K, 2) px, of keypoints (..., K, 3) as they are said at anchors (...)."""
        reach = KEYPOINT_GAIN * self.strides[anchor][..., None, None]
        return self.anchors[anchor][..., None, :] + said[..., :2].float() * reach


class PoseNetwork(nn.Module):
    """Finds parts in an image: class, box, and surface keypoints.

    Attributes:
        size: widths and depths.
        n_classes, n_keypoints: C and K.
    """

    def __init__(self, size: NetworkSize, n_classes: int, n_keypoints: int) -> None:
        super().__init__()
        self.size, self.n_classes, self.n_keypoints = size, n_classes, n_keypoints
        c, n = size.channels, size.repeats
        self.stem = nn.Sequential(ConvBlock(3, c[0], 3, 2), *_stage(c[0], c[1], n[0]))
        self.to_8 = _stage(c[1], c[2], n[1])
        self.to_16 = _stage(c[2], c[3], n[2])
        self.to_32 = nn.Sequential(*_stage(c[3], c[4], n[3]), Sppf(c[4]))
        self.up_16 = C2f(c[4] + c[3], c[3], n[0], is_residual=False)
        self.up_8 = C2f(c[3] + c[2], c[2], n[0], is_residual=False)
        self.halve_8 = ConvBlock(c[2], c[2], 3, 2)
        self.down_16 = C2f(c[2] + c[3], c[3], n[0], is_residual=False)
        self.halve_16 = ConvBlock(c[3], c[3], 3, 2)
        self.down_32 = C2f(c[3] + c[4], c[4], n[0], is_residual=False)
        self.box_heads = _heads(c[2:], size.box_channels, 4 * N_BINS)
        self.class_heads = _heads(c[2:], size.class_channels, n_classes)
        self.keypoint_heads = _heads(c[2:], size.keypoint_channels, 3 * n_keypoints)
        self._set_priors()

    def forward(self, images: Tensor) -> RawOutput:
        """Images (B, 3, H, W), red first, 0 to 1; H and W multiples of 32."""
        levels = self.pyramid(images)
        sides = _flattened(self.box_heads, levels)
        classes = _flattened(self.class_heads, levels)
        keypoints = _flattened(self.keypoint_heads, levels)
        shapes = [(level.shape[2], level.shape[3]) for level in levels]
        anchors, strides = anchor_grid(shapes, images.device)
        return RawOutput(
            sides=sides.unflatten(-1, (4, N_BINS)),
            classes=classes,
            keypoints=keypoints.unflatten(-1, (self.n_keypoints, 3)),
            anchors=anchors,
            strides=strides,
        )

    def pyramid(self, images: Tensor) -> list[Tensor]:
        """Features at strides 8, 16 and 32."""
        at_8 = self.to_8(self.stem(images))
        at_16 = self.to_16(at_8)
        at_32 = self.to_32(at_16)
        up_16 = self.up_16(torch.cat([_doubled(at_32), at_16], dim=1))
        out_8 = self.up_8(torch.cat([_doubled(up_16), at_8], dim=1))
        out_16 = self.down_16(torch.cat([self.halve_8(out_8), up_16], dim=1))
        out_32 = self.down_32(torch.cat([self.halve_16(out_16), at_32], dim=1))
        return [out_8, out_16, out_32]

    def _set_priors(self) -> None:
        """Output layers begin at what is likely: few objects, boxes of a few strides."""
        for stride, head in zip(STRIDES, self.class_heads, strict=True):
            cells = (640 / stride) ** 2
            nn.init.constant_(head[-1].bias, math.log(_CELLS_PER_OBJECT / self.n_classes / cells))
        for head in self.box_heads:
            nn.init.constant_(head[-1].bias, 1.0)
        for head in self.keypoint_heads:
            nn.init.zeros_(head[-1].bias)


def anchor_grid(shapes: list[tuple[int, int]], device: torch.device) -> tuple[Tensor, Tensor]:
    """Anchors (A, 2), px, in the middle of each cell, row by row, and their strides (A,).

    Args:
        shapes: rows and columns of the features at each stride.
        device: where they are needed.
    """
    anchors, strides = [], []
    for stride, (rows, columns) in zip(STRIDES, shapes, strict=True):
        y = (torch.arange(rows, device=device, dtype=torch.float32) + 0.5) * stride
        x = (torch.arange(columns, device=device, dtype=torch.float32) + 0.5) * stride
        grid_y, grid_x = torch.meshgrid(y, x, indexing="ij")
        anchors.append(torch.stack([grid_x, grid_y], dim=-1).reshape(-1, 2))
        strides.append(torch.full((rows * columns,), float(stride), device=device))
    return torch.cat(anchors), torch.cat(strides)


def _stage(c_in: int, c_out: int, repeats: int) -> nn.Sequential:
    return nn.Sequential(ConvBlock(c_in, c_out, 3, 2), C2f(c_out, c_out, repeats, is_residual=True))


def _heads(channels: tuple[int, ...], hidden: int, c_out: int) -> nn.ModuleList:
    return nn.ModuleList(HeadBranch(c_in, hidden, c_out) for c_in in channels)


def _doubled(x: Tensor) -> Tensor:
    return functional.interpolate(x, scale_factor=2.0, mode="nearest")


def _flattened(heads: nn.ModuleList, levels: list[Tensor]) -> Tensor:
    """(B, A, channels) of all levels, one after the other."""
    outputs = [head(level).flatten(2) for head, level in zip(heads, levels, strict=True)]
    return torch.cat(outputs, dim=2).transpose(1, 2)
