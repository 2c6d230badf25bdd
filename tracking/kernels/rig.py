"""Several cameras on one bench: poses go out to each, energies come back to the first.

The variation acts on the right, in the body's own frame, which all cameras share: gradients and
Hessians of one body add up as they are.
"""

from __future__ import annotations

from numba import njit

from snapfit.tracking.kernels.geometry import multiply_poses
from snapfit.tracking.kernels.types import F64, Bodies


@njit(cache=True, nogil=True)
def follow_first(camera_from_first: F64, first: Bodies, own: Bodies) -> None:
    """Put the bodies of a camera where the first camera's are.

    Args:
        camera_from_first: (4, 4) where the first camera stands.
        first: poses are read.
        own: poses are written, in this camera's frame.
    """
    for body in range(first.poses.shape[0]):
        multiply_poses(camera_from_first, first.poses[body], own.poses[body])


@njit(cache=True, nogil=True)
def clear_energies(bodies: Bodies) -> None:
    """No gradient and no Hessian, of active bodies."""
    for body in range(bodies.poses.shape[0]):
        if bodies.active[body]:
            bodies.gradients[body] = 0.0
            bodies.hessians[body] = 0.0


@njit(cache=True, nogil=True)
def add_energies(own: Bodies, first: Bodies) -> None:
    """Add a camera's gradients and Hessians of active bodies to the first camera's."""
    for body in range(first.poses.shape[0]):
        if first.active[body]:
            first.gradients[body] += own.gradients[body]
            first.hessians[body] += own.hessians[body]
