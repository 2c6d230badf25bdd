"""The building blocks of YOLOv8: convolution, C2f and spatial pyramid pooling.

Written from their published descriptions (Redmon et al., YOLO; Wang et al., CSPNet, 2020; Jocher
et al., YOLOv8, 2023: C2f keeps the output of every bottleneck, SPPF pools three times in a row).
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

_BATCH_EPSILON, _BATCH_MOMENTUM = 1e-3, 0.03


class ConvBlock(nn.Module):
    """Convolution, batch normalisation, SiLU; keeps the size, or divides it by the stride."""

    def __init__(self, c_in: int, c_out: int, kernel: int = 1, stride: int = 1) -> None:
        super().__init__()
        self.conv = nn.Conv2d(c_in, c_out, kernel, stride, kernel // 2, bias=False)
        self.norm = nn.BatchNorm2d(c_out, eps=_BATCH_EPSILON, momentum=_BATCH_MOMENTUM)
        self.activation = nn.SiLU(inplace=True)

    def forward(self, x: Tensor) -> Tensor:
        """(B, c_in, H, W) to (B, c_out, H / stride, W / stride)."""
        return self.activation(self.norm(self.conv(x)))

    def fused(self) -> tuple[Tensor, Tensor]:
        """Weight and bias of the one convolution that this is once it is trained."""
        scale = self.norm.weight / torch.sqrt(self.norm.running_var + self.norm.eps)
        weight = self.conv.weight * scale[:, None, None, None]
        return weight, self.norm.bias - self.norm.running_mean * scale


class Bottleneck(nn.Module):
    """Two 3x3 convolutions, beside a shortcut where wanted."""

    def __init__(self, channels: int, is_residual: bool) -> None:
        super().__init__()
        self.first = ConvBlock(channels, channels, 3)
        self.second = ConvBlock(channels, channels, 3)
        self.is_residual = is_residual

    def forward(self, x: Tensor) -> Tensor:
        """(B, C, H, W), same size."""
        y = self.second(self.first(x))
        return x + y if self.is_residual else y


class C2f(nn.Module):
    """A cross-stage partial block: half of the channels go through bottlenecks, all are kept."""

    def __init__(self, c_in: int, c_out: int, repeats: int, is_residual: bool) -> None:
        super().__init__()
        self.hidden = c_out // 2
        self.enter = ConvBlock(c_in, 2 * self.hidden)
        self.bottlenecks = nn.ModuleList(
            Bottleneck(self.hidden, is_residual) for _ in range(repeats)
        )
        self.leave = ConvBlock((2 + repeats) * self.hidden, c_out)

    def forward(self, x: Tensor) -> Tensor:
        """(B, c_in, H, W) to (B, c_out, H, W)."""
        pieces = list(self.enter(x).chunk(2, dim=1))
        for bottleneck in self.bottlenecks:
            pieces.append(bottleneck(pieces[-1]))
        return self.leave(torch.cat(pieces, dim=1))


class Sppf(nn.Module):
    """Spatial pyramid pooling, fast: one 5x5 maximum three times over sees 5, 9 and 13 pixels."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.enter = ConvBlock(channels, channels // 2)
        self.pool = nn.MaxPool2d(5, stride=1, padding=2)
        self.leave = ConvBlock(4 * (channels // 2), channels)

    def forward(self, x: Tensor) -> Tensor:
        """(B, C, H, W), same size."""
        pieces = [self.enter(x)]
        for _ in range(3):
            pieces.append(self.pool(pieces[-1]))
        return self.leave(torch.cat(pieces, dim=1))


class HeadBranch(nn.Sequential):
    """Two 3x3 convolutions and a linear layer: what one head says in one respect."""

    def __init__(self, c_in: int, hidden: int, c_out: int) -> None:
        super().__init__(
            ConvBlock(c_in, hidden, 3), ConvBlock(hidden, hidden, 3), nn.Conv2d(hidden, c_out, 1)
        )
