"""The names of detectors and of what runs a network, as settings and options say them.

Nothing is imported here: the API process reads them, and it loads no tracking.
"""

from __future__ import annotations

from typing import Literal

DetectorName = Literal["geometric", "network"]
"""By shape in the depth image, or by the asset's own network."""

DetectorWish = Literal["auto", "none", "geometric", "network"]
"""A detector, none at all, or whichever there is."""

ProviderName = Literal["cpu", "cuda", "tensorrt", "coreml", "directml"]
"""ONNX Runtime's execution providers, in short."""
