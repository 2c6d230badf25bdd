"""The software rasteriser: depth, part and normal of every pixel; no OpenGL, no GPU."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snapfit.models import raster_kernels as kernels
from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose

MAX_BODIES = 255


@dataclass
class Rendering:
    """What a camera sees of some bodies.

    Attributes:
        depth: (H, W) float32, metres along the optical axis, 0 = nothing.
        part_id: (H, W) uint8, 0 = nothing, i + 1 = the i-th body given.
        normal: (H, W, 3) float32, unit, camera frame, turned to the camera; or None.
    """

    depth: npt.NDArray[np.float32]
    part_id: npt.NDArray[np.uint8]
    normal: npt.NDArray[np.float32] | None = None

    @staticmethod
    def empty(camera: PinholeCamera, *, normals: bool = False) -> Rendering:
        """Buffers for a camera's image, with nothing in them."""
        shape = (camera.height, camera.width)
        return Rendering(
            depth=np.zeros(shape, dtype=np.float32),
            part_id=np.zeros(shape, dtype=np.uint8),
            normal=np.zeros((*shape, 3), dtype=np.float32) if normals else None,
        )

    def clear(self) -> None:
        """Nothing anywhere."""
        self.depth.fill(0)
        self.part_id.fill(0)
        if self.normal is not None:
            self.normal.fill(0)


def render(
    camera: PinholeCamera,
    bodies: Sequence[tuple[Mesh, Pose]],
    *,
    normals: bool = False,
    out: Rendering | None = None,
) -> Rendering:
    """Draw bodies; the nearest surface wins, both sides of a face are drawn.

    Args:
        camera: pixel centres at integers.
        bodies: at most 255 pairs of mesh and `camera_from_body`.
        normals: draw flat face normals too.
        out: buffers to draw into again, of the camera's size; new ones if None.

    Returns:
        The picture; `out` where that is given. What is nearer than 1 mm is cut off.

    Raises:
        ValueError: more than 255 bodies, or `out` does not fit the camera or `normals`.
    """
    if len(bodies) > MAX_BODIES:
        raise ValueError(f"at most {MAX_BODIES} bodies fit one picture, these are {len(bodies)}")
    out = _prepared(camera, normals, out)
    if out.normal is not None and normals:
        _draw_with_normals(camera, bodies, out)
    else:
        _draw(camera, bodies, out)
    return out


def intrinsics_of(camera: PinholeCamera) -> npt.NDArray[np.float64]:
    """(4,) fx, fy, cx, cy in px, as the kernels take them."""
    return np.array([camera.fx, camera.fy, camera.cx, camera.cy], dtype=np.float64)


def _prepared(camera: PinholeCamera, normals: bool, out: Rendering | None) -> Rendering:
    if out is None:
        return Rendering.empty(camera, normals=normals)
    if out.depth.shape != (camera.height, camera.width):
        raise ValueError(
            f"`out` has the shape {out.depth.shape}, "
            f"the camera's image {(camera.height, camera.width)}"
        )
    if normals and out.normal is None:
        raise ValueError("`out` has no normals; make it with Rendering.empty(..., normals=True)")
    out.clear()
    return out


def _camera_points(mesh: Mesh, pose: Pose) -> npt.NDArray[np.float64]:
    # A writable copy in C order: Numba compiles anew for a read-only array or another order.
    matrix = np.array(pose.matrix, order="C")
    points: npt.NDArray[np.float64] = kernels.to_camera(mesh.vertices, matrix)
    return points


def _draw(camera: PinholeCamera, bodies: Sequence[tuple[Mesh, Pose]], out: Rendering) -> None:
    intrinsics = intrinsics_of(camera)
    windows = [
        kernels.fill_body(
            _camera_points(mesh, pose), mesh.faces, intrinsics, i + 1, 0, out.depth, out.part_id
        )
        for i, (mesh, pose) in enumerate(bodies)
    ]
    _finish(windows, out)


def _draw_with_normals(
    camera: PinholeCamera, bodies: Sequence[tuple[Mesh, Pose]], out: Rendering
) -> None:
    intrinsics = intrinsics_of(camera)
    face_label = np.zeros(out.depth.shape, dtype=np.int32)
    windows, face_normals, n_faces = [], [], 0
    for mesh, pose in bodies:
        points = _camera_points(mesh, pose)
        windows.append(
            kernels.fill_body(points, mesh.faces, intrinsics, n_faces + 1, 1, out.depth, face_label)
        )
        face_normals.append(kernels.face_normals(points, mesh.faces))
        n_faces += len(mesh.faces)
    _finish(windows, out)
    if not bodies:
        return
    counts = [len(mesh.faces) for mesh, _ in bodies]
    part_of_face = np.repeat(np.arange(1, len(bodies) + 1, dtype=np.uint8), counts)
    kernels.resolve_faces(
        face_label, np.concatenate(face_normals), part_of_face, out.part_id, out.normal
    )


def _finish(windows: Sequence[tuple[int, int, int, int]], out: Rendering) -> None:
    """Inverse depths to metres, once, inside the smallest window around all bodies."""
    drawn = [window for window in windows if window[1] > window[0]]
    if not drawn:
        return
    tops, bottoms, lefts, rights = zip(*drawn, strict=True)
    kernels.finish_depth(out.depth, min(tops), max(bottoms), min(lefts), max(rights))
