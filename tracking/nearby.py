"""Modelled occlusion: a small rendering of all bodies where they are expected."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import simplified
from snapfit.tracking.body import Body
from snapfit.tracking.kernels.nearby import render_nearby
from snapfit.tracking.kernels.types import Bodies, OcclusionSettings
from snapfit.tracking.parameters import OcclusionParameters


class Shown(NamedTuple):
    """A copy of a rendering; see `NearbyRendering`."""

    depth: npt.NDArray[np.float32]
    part_id: npt.NDArray[np.uint8]
    neighboured: npt.NDArray[np.uint8]


class NearbyRendering:
    """Which body is in front where, at a quarter of the image's size, from simplified meshes.

    Attributes:
        depth: (h, w) float32, m, 0 is nothing.
        part_id: (h, w) uint8, index of the body + 1, 0 is nothing.
        neighboured: (B,) 1 where a body's image may touch another's.
    """

    def __init__(
        self, bodies: Sequence[Body], camera: PinholeCamera, parameters: OcclusionParameters
    ) -> None:
        small = camera.scaled(parameters.image_scale if parameters.modelled else 0.01)
        meshes = [simplified(body.mesh, parameters.faces_max) for body in bodies]
        self._vertices = np.concatenate([mesh.vertices for mesh in meshes])
        self._faces = np.concatenate([mesh.faces for mesh in meshes])
        sizes = [(len(mesh.vertices), len(mesh.faces)) for mesh in meshes]
        self._starts = np.cumsum([(0, 0), *sizes], axis=0, dtype=np.int64)
        self._centers = np.array([body.mesh.center_m for body in bodies], dtype=np.float32)
        self._radii = np.array([body.mesh.radius_m for body in bodies], dtype=np.float64)
        self._intrinsics = np.array([small.fx, small.fy, small.cx, small.cy])
        self.depth: npt.NDArray[np.float32] = np.zeros(
            (small.height, small.width), dtype=np.float32
        )
        self.part_id: npt.NDArray[np.uint8] = np.zeros((small.height, small.width), dtype=np.uint8)
        self.neighboured: npt.NDArray[np.uint8] = np.zeros(len(bodies), dtype=np.uint8)

    def render(self, bodies: Bodies) -> None:
        """Draw the active bodies at their poses."""
        render_nearby(
            self._vertices,
            self._faces,
            self._starts,
            self._centers,
            self._radii,
            bodies.active,
            bodies.poses,
            self._intrinsics,
            self.depth,
            self.part_id,
            self.neighboured,
        )

    def shown(self, bodies: Bodies) -> Shown:
        """Draw the bodies anew, for an attempt; returns what was there, for `put_back`."""
        kept = Shown(self.depth.copy(), self.part_id.copy(), self.neighboured.copy())
        self.render(bodies)
        return kept

    def put_back(self, shown: Shown) -> None:
        """Undo `shown`."""
        self.depth[:], self.part_id[:], self.neighboured[:] = shown


def occlusion_settings(parameters: OcclusionParameters, *, has_depth: bool) -> OcclusionSettings:
    """The parameters as the kernels take them; without a depth camera nothing is measured."""
    return OcclusionSettings(
        measured=parameters.measured and has_depth,
        modelled=parameters.modelled,
        radius=np.float32(parameters.radius_m),
        modelled_threshold=np.float32(parameters.modelled_threshold_m),
        image_scale=np.float32(parameters.image_scale),
    )
