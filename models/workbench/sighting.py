"""One part in one picture: where its outline is, and what is seen of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render

Box = tuple[int, int, int, int]
NO_BOX: Box = (-1, -1, -1, -1)


@dataclass(frozen=True, eq=False)
class Sighting:
    """One part in one frame.

    Attributes:
        camera_from_body: true pose.
        mask: (H, W) bool, where it is seen.
        n_pixels: of its whole outline, beyond the border too.
        n_seen: of the mask.
        n_measured: of the outline, where depth is measured.
        box: x, y, width, height of the outline, beyond the border too, px.
        box_inside: the same of what of the outline is inside the picture.
        box_seen: the same of the mask; (-1, -1, -1, -1) if nothing is seen.
    """

    camera_from_body: Pose
    mask: npt.NDArray[np.bool_]
    n_pixels: int
    n_seen: int
    n_measured: int
    box: Box
    box_inside: Box
    box_seen: Box

    @property
    def visibility(self) -> float:
        """Share of the outline that is seen, 0 to 1."""
        return min(self.n_seen / self.n_pixels, 1.0) if self.n_pixels else 0.0


def sighting(
    camera: PinholeCamera,
    mesh: Mesh,
    camera_from_body: Pose,
    mask: npt.NDArray[np.bool_],
    depth: npt.NDArray[np.uint16],
) -> Sighting:
    """What is to be said of a part in a picture.

    Args:
        camera: that made it.
        mesh: of the part, all of it in front of the camera.
        camera_from_body: its pose.
        mask: (H, W) where it is seen.
        depth: (H, W) measured depth, 0 is none.
    """
    alone, left, top = _outline(camera, mesh, camera_from_body)
    rows = slice(max(top, 0), max(min(top + alone.shape[0], camera.height), 0))
    columns = slice(max(left, 0), max(min(left + alone.shape[1], camera.width), 0))
    inside = alone[
        max(rows.start - top, 0) : max(rows.stop - top, 0),
        max(columns.start - left, 0) : max(columns.stop - left, 0),
    ]
    n_measured = 0
    if inside.size:
        n_measured = int(np.count_nonzero(inside & (depth[rows, columns] > 0)))
    return Sighting(
        camera_from_body,
        mask,
        int(np.count_nonzero(alone)),
        int(np.count_nonzero(mask)),
        n_measured,
        _shifted(box_of(alone), left, top),
        _shifted(box_of(inside), columns.start, rows.start),
        box_of(mask),
    )


def box_of(mask: npt.NDArray[np.bool_]) -> Box:
    """x, y, width, height of what is true in a mask (H, W); (-1, -1, -1, -1) if nothing is."""
    rows = np.flatnonzero(mask.any(axis=1))
    if len(rows) == 0:
        return NO_BOX
    columns = np.flatnonzero(mask.any(axis=0))
    x, y = int(columns[0]), int(rows[0])
    return x, y, int(columns[-1]) - x + 1, int(rows[-1]) - y + 1


def _outline(
    camera: PinholeCamera, mesh: Mesh, pose: Pose
) -> tuple[npt.NDArray[np.bool_], int, int]:
    """A part alone, in a window of its own: (h, w) mask; column and row where it begins."""
    pixels = camera.project(pose.transform(mesh.vertices))
    left, top = (int(value) for value in np.floor(pixels.min(axis=0)))
    right, bottom = (int(value) + 1 for value in np.ceil(pixels.max(axis=0)))
    window = PinholeCamera(
        right - left, bottom - top, camera.fx, camera.fy, camera.cx - left, camera.cy - top
    )
    return render(window, [(mesh, pose)]).part_id > 0, left, top


def _shifted(box: Box, left: int, top: int) -> Box:
    return box if box == NO_BOX else (box[0] + left, box[1] + top, box[2], box[3])
