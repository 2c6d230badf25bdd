"""Eight-bit weights and activations, by ONNX Runtime's static quantisation.

Only the convolutions of the backbone, the neck and the heads' hidden layers are quantised. What
the last layers say is pixels: eight bits are too coarse for them.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import onnx
from onnxruntime.quantization import (
    CalibrationDataReader,
    CalibrationMethod,
    QuantFormat,
    QuantType,
    quantize_static,
)

from snapfit.models.detector.export import INPUT_NAME, export_onnx
from snapfit.models.detector.network import PoseNetwork

_OPERATORS = ["Conv", "Mul", "Sigmoid", "Add", "Concat", "Split", "Resize", "MaxPool"]


class _Images(CalibrationDataReader):
    def __init__(self, blobs: Sequence[npt.NDArray[np.float32]]) -> None:
        self._left: Iterator[npt.NDArray[np.float32]] = iter(blobs)

    def get_next(self) -> dict[str, npt.NDArray[np.float32]] | None:
        """The next input; None at the end."""
        blob = next(self._left, None)
        return None if blob is None else {INPUT_NAME: blob}


def write_int8(network: PoseNetwork, path: Path, blobs: Sequence[npt.NDArray[np.float32]]) -> None:
    """Writes an eight-bit network.

    Args:
        network: that was trained.
        path: of the `.onnx` file.
        blobs: inputs (1, 3, H, W) from which the range of each activation is taken.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "single.onnx"
        export_onnx(network, source, halves_weights=False)
        quantize_static(
            source,
            path,
            _Images(blobs),
            quant_format=QuantFormat.QDQ,
            per_channel=True,
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
            op_types_to_quantize=_OPERATORS,
            nodes_to_exclude=last_nodes(onnx.load(source)),
            calibrate_method=CalibrationMethod.MinMax,
        )


def last_nodes(model: onnx.ModelProto) -> list[str]:
    """Names of the convolutions that no activation follows, and of all that comes after them."""
    activated = {node.input[0] for node in model.graph.node if node.op_type == "Sigmoid"}
    after: set[str] = set()
    names = []
    for node in model.graph.node:
        is_linear = node.op_type == "Conv" and node.output[0] not in activated
        if is_linear or after & set(node.input):
            after |= set(node.output)
            names.append(node.name)
    return names
