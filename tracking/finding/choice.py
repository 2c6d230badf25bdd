"""Which detector a station gets where it may be any."""

from __future__ import annotations

import logging
from pathlib import Path

from snapfit.models.detector.card import ONNX_NAME
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.names import DetectorName, DetectorWish
from snapfit.tracking.finding.open3d_module import open3d

_LOG = logging.getLogger(__name__)


def chosen_detector(
    wish: DetectorWish, bundle: Path | None, *, has_depth: bool
) -> DetectorName | None:
    """The detector that is wished for; for "auto" the best that there is.

    The asset's own network where its bundle has one, else the geometric one where there is depth
    and Open3D, else none; the log says why. Whether a network that is there can be used is not
    looked at here: a damaged one is to be refused, not passed over.

    Args:
        wish: a detector, "none" or "auto".
        bundle: the asset's folder; None for loose parts.
        has_depth: whether the camera measures depth.
    """
    if wish == "none":
        return None
    if wish != "auto":
        return wish
    if bundle is not None and (bundle / ONNX_NAME).is_file():
        return "network"
    missing = "there is no depth camera"
    if has_depth:
        try:
            open3d()
        except TrackingError as error:
            missing = str(error)
        else:
            return "geometric"
    _LOG.warning(
        "parts are not found by themselves, the source has to bring their first poses: "
        "the asset has no %s, and for the geometric detector: %s",
        ONNX_NAME,
        missing,
    )
    return None
