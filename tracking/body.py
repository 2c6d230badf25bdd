"""What the tracker knows of a part before the first frame: name, meshes, viewpoint model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Part
from snapfit.models.mesh import Mesh
from snapfit.models.viewpoint_cache import load_viewpoint_model
from snapfit.models.viewpoint_model import ViewpointModel
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.kernels.types import Models

_ALIKE = 12.0
"""Distance in CIELAB below which the edge between two parts cannot be relied upon."""


@dataclass(frozen=True, eq=False)
class Body:
    """A part as the tracker sees it.

    Attributes:
        name: the part's name.
        mesh: surface, metres, body frame.
        views: its sparse viewpoint model.
        color_rgb: its colour, 0 to 255 each; tells which parts look alike.
    """

    name: str
    mesh: Mesh
    views: ViewpointModel
    color_rgb: tuple[int, int, int] = (160, 160, 160)


def load_bodies(
    parts: Sequence[Part], progress: Callable[[str, float], None] | None = None
) -> tuple[Body, ...]:
    """The bodies of parts, with viewpoint models from the cache or made now.

    Args:
        parts: what is to be tracked.
        progress: called with a message and the share that is done, 0 to 1.

    Raises:
        TrackingError: no part, or two of one name.
        ViewpointModelError: a model can neither be read nor made.
    """
    names = [part.name for part in parts]
    if not names:
        raise TrackingError("there is no part to track: the asset has none with `tracked = true`")
    if len(set(names)) != len(names):
        raise TrackingError(f"two parts have the same name: {', '.join(sorted(names))}")
    bodies = []
    for i, part in enumerate(parts):

        def report(share: float, i: int = i, name: str = part.name) -> None:
            if progress is not None:
                progress(f"viewpoint model of {name}", (i + share) / len(parts))

        views = load_viewpoint_model(part.mesh, report)
        bodies.append(Body(part.name, part.mesh, views, part.color_rgb))
    return tuple(bodies)


def pack_models(bodies: Sequence[Body], lines_max: int, points_max: int) -> Models:
    """The bodies' viewpoint models side by side, as the kernels take them.

    Views get lines in proportion to their contour's length and points in proportion to their
    surface ("adaptive coverage", M3T): a bar seen from its end does not crowd its few pixels.
    The result holds addresses: the bodies must live as long as it is used.

    Raises:
        TrackingError: the models differ in size or type.
    """
    # One set of rows a view, so that the kernels need no other number to find a view.
    if len({body.views.contour.shape for body in bodies}) != 1:
        raise TrackingError("the viewpoint models differ in size: clear the cache of models")
    n_rows = bodies[0].views.contour.shape[1]
    if max(lines_max, points_max) > n_rows:
        raise TrackingError(
            f"lines_max {lines_max} and points_max {points_max}: a view has {n_rows} at most"
        )
    return Models(
        directions=np.array(bodies[0].views.directions, dtype=np.float32),
        neighbours=np.array(bodies[0].views.neighbours, dtype=np.int16),
        contours=_addresses([body.views.contour for body in bodies]),
        surfaces=_addresses([body.views.surface for body in bodies]),
        n_rows=n_rows,
        units=np.array([body.views.unit_m for body in bodies], dtype=np.float32),
        centers=np.array([body.views.center_m for body in bodies], dtype=np.float32),
        line_counts=_counts([body.views.contour_length_m for body in bodies], lines_max),
        point_counts=_counts([body.views.surface_area_m2 for body in bodies], points_max),
    )


def alike(colors_rgb: Sequence[tuple[int, int, int]]) -> npt.NDArray[np.uint8]:
    """(N, N) 1 where two colours, 0 to 255 each, are nearly the same; 0 on the diagonal."""
    lab = cv2.cvtColor(np.array([colors_rgb], dtype=np.float32) / 255, cv2.COLOR_RGB2LAB)[0]
    apart = np.linalg.norm(lab[:, None] - lab[None], axis=2)
    same: npt.NDArray[np.uint8] = (apart < _ALIKE).astype(np.uint8)
    np.fill_diagonal(same, 0)
    return same


def _addresses(arrays: Sequence[npt.NDArray[np.int16]]) -> npt.NDArray[np.int64]:
    """(B,) where the arrays lie; a memory-mapped one is read only where a view is looked at."""
    for array in arrays:
        if array.dtype != np.int16 or not array.flags.c_contiguous:
            raise TrackingError("a viewpoint model is not int16 in C order")
    return np.array([array.ctypes.data for array in arrays], dtype=np.int64)


def _counts(measures: Sequence[npt.NDArray[np.float32]], most: int) -> npt.NDArray[np.int64]:
    shares = [np.asarray(measure) / np.asarray(measure).max() for measure in measures]
    counts: npt.NDArray[np.int64] = np.ceil(np.array(shares) * most).astype(np.int64)
    return counts
