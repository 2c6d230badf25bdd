"""The closest view of a sparse viewpoint model: hill climbing over the geodesic grid."""

from __future__ import annotations

from numba import njit

from snapfit.tracking.kernels.types import F32, F64, FAST, I16


@njit(cache=True, nogil=True, fastmath=FAST)
def closest_view(directions: F32, neighbours: I16, pose: F64, center: F32, start: int) -> int:
    """The view whose direction is nearest to the camera's, seen from the body.

    On a geodesic grid the dot product has one summit, so that climbing from the last view finds
    what a scan of all of them finds (the reference scans 2562), in a few steps.

    Args:
        directions: (V, 3) unit, body frame, from the centre to the viewpoint.
        neighbours: (V, 6) adjacent views.
        pose: (4, 4) camera_from_body.
        center: (3,) centre of the viewpoints, body frame, m.
        start: view to climb from.
    """
    # The camera's place in the body frame is -R^T t; from the centre to there:
    dx = -(pose[0, 0] * pose[0, 3] + pose[1, 0] * pose[1, 3] + pose[2, 0] * pose[2, 3]) - center[0]
    dy = -(pose[0, 1] * pose[0, 3] + pose[1, 1] * pose[1, 3] + pose[2, 1] * pose[2, 3]) - center[1]
    dz = -(pose[0, 2] * pose[0, 3] + pose[1, 2] * pose[1, 3] + pose[2, 2] * pose[2, 3]) - center[2]
    best = start
    best_dot = dx * directions[best, 0] + dy * directions[best, 1] + dz * directions[best, 2]
    climbing = True
    while climbing:
        climbing = False
        at = best
        for k in range(neighbours.shape[1]):
            view = int(neighbours[at, k])
            dot = dx * directions[view, 0] + dy * directions[view, 1] + dz * directions[view, 2]
            if dot > best_dot:
                best, best_dot, climbing = view, dot, True
    return best
