"""Writes a trained network as ONNX, decoded, in the public layout of Ultralytics' pose models.

Input `images` (B, 3, H, W), red first, 0 to 1, H and W any multiples of 32. Output `output0`
(B, 4 + C + 3 K, A): rows are the box's centre x, y, width and height (px of the input), a score
for each class, then x, y (px) and presence of each keypoint; columns are anchors.

The graph is written by hand, with batch normalisation folded into the convolutions: it needs
nothing but `onnx`, and its names and its opset are ours to keep.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from snapfit.models.detector.blocks import C2f, ConvBlock, HeadBranch, Sppf
from snapfit.models.detector.network import KEYPOINT_GAIN, PoseNetwork
from snapfit.models.detector.onnx_graph import OnnxGraph
from snapfit.models.detector.size import N_BINS, STRIDES

INPUT_NAME, OUTPUT_NAME = "images", "output0"


def export_onnx(
    network: PoseNetwork,
    path: Path,
    *,
    halves_weights: bool = True,
    input_size: tuple[int, int] | None = None,
    metadata: dict[str, str] | None = None,
) -> None:
    """Writes the network.

    Args:
        network: in whatever mode; its running statistics are used.
        path: of the `.onnx` file.
        halves_weights: keep them in half precision, which halves the file.
        input_size: height and width, px, where they are to be fixed; None leaves them free.
        metadata: what the file says of itself.
    """
    with torch.no_grad():
        graph = OnnxGraph(halves_weights=halves_weights)
        levels = _pyramid(graph, network)
        _decoded(graph, network, levels)
    height, width = input_size or ("height", "width")
    rows = 4 + network.n_classes + 3 * network.n_keypoints
    graph.written(
        path,
        (INPUT_NAME, ("batch", 3, height, width)),
        (OUTPUT_NAME, ("batch", rows, "anchors")),
        metadata or {},
    )


def _pyramid(graph: OnnxGraph, network: PoseNetwork) -> list[str]:
    """As `PoseNetwork.pyramid`."""
    at_8 = _layer(graph, network.to_8, _layer(graph, network.stem, INPUT_NAME))
    at_16 = _layer(graph, network.to_16, at_8)
    at_32 = _layer(graph, network.to_32, at_16)
    up_16 = _layer(graph, network.up_16, _joined(graph, [_doubled(graph, at_32), at_16]))
    out_8 = _layer(graph, network.up_8, _joined(graph, [_doubled(graph, up_16), at_8]))
    halved_8 = _layer(graph, network.halve_8, out_8)
    out_16 = _layer(graph, network.down_16, _joined(graph, [halved_8, up_16]))
    halved_16 = _layer(graph, network.halve_16, out_16)
    out_32 = _layer(graph, network.down_32, _joined(graph, [halved_16, at_32]))
    return [out_8, out_16, out_32]


def _decoded(graph: OnnxGraph, network: PoseNetwork, levels: Sequence[str]) -> None:
    """Boxes, scores and keypoints of all anchors, as `RawOutput` decodes them."""
    anchors, strides = _anchors(graph, levels)
    heads = network.box_heads, network.class_heads, network.keypoint_heads
    widths = 4 * N_BINS, network.n_classes, 3 * network.n_keypoints
    sides, classes, keypoints = (
        _flattened(graph, each, levels, width) for each, width in zip(heads, widths, strict=True)
    )
    parts = [
        _boxes(graph, sides, anchors, strides),
        graph.node("Sigmoid", classes),
        _keypoints(graph, network.n_keypoints, keypoints, anchors, strides),
    ]
    graph.node("Concat", *parts, axis=1, name=OUTPUT_NAME)


def _boxes(graph: OnnxGraph, sides: str, anchors: str, strides: str) -> str:
    """(B, 4, A) centre, width and height."""
    shape = graph.array([0, 4, N_BINS, -1], np.int64)
    shares = graph.node("Softmax", graph.node("Reshape", sides, shape), axis=2)
    bins = graph.array(np.arange(N_BINS).reshape(1, 1, N_BINS, 1))
    weighted = graph.node("Mul", shares, bins)
    axes = graph.array([2], np.int64)
    distances = graph.node("ReduceSum", weighted, axes, keepdims=0)
    distances = graph.node("Mul", distances, strides)
    near, far = graph.split(distances, 1, [2, 2])
    first = graph.node("Sub", anchors, near)
    last = graph.node("Add", anchors, far)
    center = graph.node("Mul", graph.node("Add", first, last), graph.array([0.5]))
    return graph.node("Concat", center, graph.node("Sub", last, first), axis=1)


def _keypoints(graph: OnnxGraph, n: int, raw: str, anchors: str, strides: str) -> str:
    """(B, 3 n, A) x, y and presence of each."""
    raw = graph.node("Reshape", raw, graph.array([0, n, 3, -1], np.int64))
    offsets, presence = graph.split(raw, 2, [2, 1])
    reach = graph.node("Mul", strides, graph.array([KEYPOINT_GAIN]))
    places = graph.node("Add", graph.node("Mul", offsets, reach), anchors)
    both = graph.node("Concat", places, graph.node("Sigmoid", presence), axis=2)
    return graph.node("Reshape", both, graph.array([0, 3 * n, -1], np.int64))


def _anchors(graph: OnnxGraph, levels: Sequence[str]) -> tuple[str, str]:
    """As `anchor_grid`: (2, A) places and (1, A) strides, px, for any size of the input."""
    places, strides = [], []
    for stride, level in zip(STRIDES, levels, strict=True):
        rows = graph.node("Shape", level, start=2, end=3)
        columns = graph.node("Shape", level, start=3, end=4)
        shape = graph.node("Concat", rows, columns, axis=0)
        x = graph.node("Expand", _steps(graph, columns, stride, (1, -1)), shape)
        y = graph.node("Expand", _steps(graph, rows, stride, (-1, 1)), shape)
        flat = graph.array([1, -1], np.int64)
        both = [graph.node("Reshape", each, flat) for each in (x, y)]
        places.append(graph.node("Concat", *both, axis=0))
        zeros = graph.node("Mul", both[0], graph.array([0.0]))
        strides.append(graph.node("Add", zeros, graph.array([float(stride)])))
    return graph.node("Concat", *places, axis=1), graph.node("Concat", *strides, axis=1)


def _steps(graph: OnnxGraph, count: str, stride: int, shape: tuple[int, int]) -> str:
    """The middles of `count` cells in a row, px."""
    scalar = graph.node("Squeeze", graph.node("Cast", count, to=1))
    limits = [graph.array(0.0), scalar, graph.array(1.0)]
    middles = graph.node("Add", graph.node("Range", *limits), graph.array([0.5]))
    in_px = graph.node("Mul", middles, graph.array([float(stride)]))
    return graph.node("Reshape", in_px, graph.array(shape, np.int64))


def _flattened(graph: OnnxGraph, heads: nn.ModuleList, levels: Sequence[str], width: int) -> str:
    shape = graph.array([0, width, -1], np.int64)
    outputs = [_layer(graph, head, level) for head, level in zip(heads, levels, strict=True)]
    return graph.node("Concat", *(graph.node("Reshape", o, shape) for o in outputs), axis=2)


def _layer(graph: OnnxGraph, layer: nn.Module, x: str) -> str:
    if isinstance(layer, ConvBlock):
        y = _convolution(graph, layer.conv, x, *layer.fused())
        return graph.node("Mul", y, graph.node("Sigmoid", y))
    if isinstance(layer, nn.Conv2d):
        return _convolution(graph, layer, x, layer.weight, layer.bias)
    if isinstance(layer, C2f):
        return _c2f(graph, layer, x)
    if isinstance(layer, Sppf):
        return _sppf(graph, layer, x)
    if isinstance(layer, nn.Sequential | HeadBranch):
        for each in layer:
            x = _layer(graph, each, x)
        return x
    raise TypeError(f"no rule to export a {type(layer).__name__}")


def _c2f(graph: OnnxGraph, layer: C2f, x: str) -> str:
    pieces = graph.split(_layer(graph, layer.enter, x), 1, [layer.hidden, layer.hidden])
    for bottleneck in layer.bottlenecks:
        y = _layer(graph, bottleneck.second, _layer(graph, bottleneck.first, pieces[-1]))
        pieces.append(graph.node("Add", pieces[-1], y) if bottleneck.is_residual else y)
    return _layer(graph, layer.leave, _joined(graph, pieces))


def _sppf(graph: OnnxGraph, layer: Sppf, x: str) -> str:
    pieces = [_layer(graph, layer.enter, x)]
    for _ in range(3):
        pool = graph.node("MaxPool", pieces[-1], kernel_shape=[5, 5], pads=[2, 2, 2, 2])
        pieces.append(pool)
    return _layer(graph, layer.leave, _joined(graph, pieces))


def _convolution(graph: OnnxGraph, conv: nn.Conv2d, x: str, weight: Tensor, bias: Tensor) -> str:
    arrays = [graph.array(each.detach().cpu().float().numpy()) for each in (weight, bias)]
    padding = conv.padding[0]
    return graph.node(
        "Conv",
        x,
        *arrays,
        kernel_shape=list(conv.kernel_size),
        strides=list(conv.stride),
        pads=[padding] * 4,
    )


def _joined(graph: OnnxGraph, pieces: Sequence[str]) -> str:
    return graph.node("Concat", *pieces, axis=1)


def _doubled(graph: OnnxGraph, x: str) -> str:
    scales = graph.array([1.0, 1.0, 2.0, 2.0])
    return graph.node(
        "Resize",
        x,
        "",
        scales,
        mode="nearest",
        nearest_mode="floor",
        coordinate_transformation_mode="asymmetric",
    )
