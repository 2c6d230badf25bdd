"""The Numba kernel that fills views of a viewpoint model: many a call, without the GIL."""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

from snapfit.models.raster_kernels import fill_body, project, to_camera
from snapfit.models.viewpoint_contour import (
    Crossings,
    clear_crossings,
    find_crossings,
    follow_contours,
)
from snapfit.models.viewpoint_sampling import (
    View,
    fill_contour,
    fill_surface,
    nearest_of_cells,
)

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int32]
Shorts = npt.NDArray[np.int16]


@numba.njit(nogil=True, cache=True)
def fill_views(
    poses: Floats,
    vertices: Singles,
    faces: Ints,
    edges: Ints,
    normals: Singles,
    camera: Floats,
    cell_px: int,
    occlusion_radius_m: float,
    unit_m: float,
    crossings: Crossings,
    contour: Shorts,
    surface: Shorts,
    extents: Singles,
) -> None:
    """Fill some views.

    Args:
        poses: (n, 4, 4) camera_from_body.
        vertices: (V, 3) m, body frame.
        faces: (F, 3).
        edges: (E, 5), see `find_crossings`.
        normals: (F, 3) unit, body frame, of either side.
        camera: (4,) fx, fy, cx, cy in px of the square image.
        cell_px: width of the cells in which depth offsets are looked for.
        occlusion_radius_m: how far around a point they are looked for.
        unit_m: of the positions and distances.
        crossings: room to work in, as large as the image.
        contour: (n, P, 9), filled.
        surface: (n, P, 7), filled.
        extents: (n, 2) contour length in m and number of pixels of the silhouette, filled.
    """
    size = crossings.number.shape[1]
    inverse_depth = np.zeros((size, size), dtype=np.float32)
    labels = np.zeros((size, size), dtype=np.int32)
    n_cells = (size + cell_px - 1) // cell_px
    cells = np.zeros((n_cells, n_cells), dtype=np.float32)
    # Typed, because Numba compiles the callee once more for a literal.
    one = np.int64(1)
    for i in range(len(poses)):
        points = to_camera(vertices, poses[i])
        window = fill_body(points, faces, camera, one, one, inverse_depth, labels)
        find_crossings(points, project(points, camera), faces, edges, labels, crossings)
        follow_contours(labels, inverse_depth, camera, crossings)
        n_pixels = nearest_of_cells(inverse_depth, window, cell_px, cells)
        view = View(
            poses[i],
            camera,
            labels,
            inverse_depth,
            cells,
            cell_px,
            window,
            occlusion_radius_m,
            unit_m,
        )
        extents[i, 0] = fill_contour(view, crossings, contour[i])
        extents[i, 1] = n_pixels
        if n_pixels > 0:
            fill_surface(view, normals, surface[i])
        clear_crossings(crossings)
        inverse_depth.fill(0)
        labels.fill(0)
