"""Writes an ONNX graph node by node: a thin layer over `onnx.helper` that invents the names."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import onnx
from onnx import TensorProto, helper, numpy_helper

OPSET = 17
_IR_VERSION = 8
# Smaller arrays are shapes and factors, whose rounding would be felt.
_LEAST_HALVED = 256


class OnnxGraph:
    """A graph that grows.

    Attributes:
        halves_weights: whether large arrays are kept in half precision; they are widened when the
            network is loaded, so that it computes in single precision all the same.
    """

    def __init__(self, *, halves_weights: bool = False) -> None:
        self.halves_weights = halves_weights
        self._nodes: list[Any] = []
        self._arrays: list[Any] = []

    def node(self, operator: str, *inputs: str, name: str = "", **attributes: Any) -> str:
        """Adds a node with one output; returns the output's name."""
        output = name or f"{operator.lower()}_{len(self._nodes)}"
        self._nodes.append(helper.make_node(operator, inputs, [output], name=output, **attributes))
        return output

    def array(self, values: npt.ArrayLike, kind: type = np.float32) -> str:
        """Adds a constant; returns its name."""
        array: npt.NDArray[Any] = np.asarray(values, dtype=kind)
        name = f"array_{len(self._arrays)}"
        if self.halves_weights and array.dtype == np.float32 and array.size >= _LEAST_HALVED:
            self._arrays.append(numpy_helper.from_array(array.astype(np.float16), name))
            return self.node("Cast", name, to=TensorProto.FLOAT)
        self._arrays.append(numpy_helper.from_array(array, name))
        return name

    def split(self, x: str, axis: int, sizes: Sequence[int]) -> list[str]:
        """Cuts along an axis; returns the pieces' names."""
        first = len(self._nodes)
        outputs = [f"split_{first}_{i}" for i in range(len(sizes))]
        lengths = self.array(sizes, np.int64)
        inputs = [x, lengths]
        self._nodes.append(helper.make_node("Split", inputs, outputs, f"split_{first}", axis=axis))
        return outputs

    def written(
        self,
        path: Path,
        given: tuple[str, Sequence[int | str]],
        result: tuple[str, Sequence[int | str]],
        metadata: dict[str, str],
    ) -> None:
        """Checks the graph and writes it.

        Args:
            path: of the file.
            given: name and shape of the input; words stand for sizes that are free.
            result: name and shape of the output.
            metadata: what the file says of itself.
        """
        graph = helper.make_graph(
            self._nodes,
            "snapfit",
            [helper.make_tensor_value_info(given[0], TensorProto.FLOAT, list(given[1]))],
            [helper.make_tensor_value_info(result[0], TensorProto.FLOAT, list(result[1]))],
            self._arrays,
        )
        opset = [helper.make_opsetid("", OPSET)]
        model = helper.make_model(graph, opset_imports=opset, producer_name="snapfit")
        model.ir_version = _IR_VERSION
        helper.set_model_props(model, metadata)
        onnx.checker.check_model(model)
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_suffix(".partial")
        onnx.save(model, unfinished)
        unfinished.replace(path)
