"""What of this machine runs a network: ONNX Runtime's execution providers by short names."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from snapfit.tracking.detection.parameters import CPU
from snapfit.tracking.errors import TrackingError

_LOG = logging.getLogger(__name__)

PROVIDERS: Mapping[str, str] = MappingProxyType(
    {
        "cpu": CPU,
        "cuda": "CUDAExecutionProvider",
        "tensorrt": "TensorrtExecutionProvider",
        "coreml": "CoreMLExecutionProvider",
        "directml": "DmlExecutionProvider",
    }
)
"""ONNX Runtime's names by ours."""


def providers_here(names: Sequence[str]) -> tuple[str, ...]:
    """ONNX Runtime's names of providers that it has here, in order; the CPU at the end.

    One that it has not is told in the log: the network runs without it, only slower.

    Args:
        names: of `PROVIDERS`, the first choice first.

    Raises:
        TrackingError: an unknown name, or ONNX Runtime cannot be loaded.
    """
    for name in names:
        if name not in PROVIDERS:
            known = ", ".join(PROVIDERS)
            raise TrackingError(f"there is no provider {name!r}; the providers are {known}")
    try:
        import onnxruntime
    except ImportError as error:
        problem = f"finding parts needs ONNX Runtime, which cannot be loaded: {error}"
        raise TrackingError(problem) from error
    there = onnxruntime.get_available_providers()
    for name in names:
        if PROVIDERS[name] not in there:
            _LOG.warning(
                "this build of ONNX Runtime has no provider %r; it has %s", name, ", ".join(there)
            )
    chosen = [PROVIDERS[name] for name in names if PROVIDERS[name] in there]
    return tuple(dict.fromkeys([*chosen, CPU]))


def short_name(provider: str) -> str:
    """Our name of one of ONNX Runtime's providers; its own where we have none."""
    return next((name for name, theirs in PROVIDERS.items() if theirs == provider), provider)
