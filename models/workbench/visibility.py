"""How much of each part is seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render


def visibility(
    camera: PinholeCamera,
    bodies: Sequence[tuple[Mesh, Pose]],
    part_id: npt.NDArray[np.uint8],
) -> list[float]:
    """Share of each body's silhouette that is seen, 0 to 1, as BOP's `visib_fract`.

    The silhouette is what would be seen of the body alone, beyond the picture's border too.

    Args:
        camera: that made the picture.
        bodies: mesh and `camera_from_body`, in front of the camera.
        part_id: (H, W) of the picture; the i-th body is i + 1.
    """
    shares = []
    for i, (mesh, pose) in enumerate(bodies):
        pixels = camera.project(pose.transform(mesh.vertices))
        left, top = np.floor(pixels.min(axis=0)).astype(int)
        right, bottom = np.ceil(pixels.max(axis=0)).astype(int) + 1
        window = PinholeCamera(
            int(right - left),
            int(bottom - top),
            camera.fx,
            camera.fy,
            camera.cx - float(left),
            camera.cy - float(top),
        )
        alone = int((render(window, [(mesh, pose)]).part_id > 0).sum())
        seen = int((part_id == i + 1).sum())
        shares.append(min(seen / alone, 1.0) if alone else 0.0)
    return shares
