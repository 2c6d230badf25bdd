"""What looks with a network: guided by shape where that is possible, and shape alone beside."""

from __future__ import annotations

import logging
from collections.abc import Sequence

from snapfit.models.camera import RgbdCamera
from snapfit.tracking.body import Body
from snapfit.tracking.detection.detector import Detector
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.finder import Finder
from snapfit.tracking.finding.geometric import GeometricFinder
from snapfit.tracking.finding.guided import GuidedFinder
from snapfit.tracking.finding.open3d_module import open3d

_LOG = logging.getLogger(__name__)


def finders_in_turn(finder: Finder, bodies: Sequence[Body]) -> tuple[tuple[str, Finder], ...]:
    """Finders by the name of their kind, that which looks first comes first.

    Beside a guided finder shape alone looks too: of parts that lie free it finds nearly all, also
    such as the network does not know from what lies around. It looks second: it takes longer the
    more is missing, and in the midst of an assembly it finds little.

    Args:
        finder: as `guided` gives it.
        bodies: the parts, with their viewpoint models.
    """
    if not isinstance(finder, GuidedFinder):
        return (("network", finder),)
    return ("network", finder), ("geometric", GeometricFinder(bodies, finder.camera))


def guided(detector: Detector, bodies: Sequence[Body], camera: RgbdCamera) -> Finder:
    """The detector with shape beside, where there is depth and Open3D; else the detector alone.

    Args:
        detector: the network.
        bodies: the parts, with their viewpoint models.
        camera: where the frames come from.
    """
    if camera.depth is None:
        return detector
    try:
        open3d()
    except TrackingError as error:
        _LOG.warning("the network finds parts without the help of their shapes: %s", error)
        return detector
    return GuidedFinder(detector, bodies, camera)
