"""The Newton step of a kinematic structure: bodies in a tree of joints (Stoiber et al., Mb-ICG).

The energy of a structure is the sum of its bodies'. A body's variation follows from its parent's
and its joint's, x = Ad(child_from_parent) x_parent + S dq. From the leaves to the root each joint's
coordinates are eliminated (a Schur complement, as Featherstone's articulated bodies do with forces)
so that six unknowns are left, and the cost grows with the number of bodies, not with its cube.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from snapfit.tracking.kernels.solve import apply_variation, exponential, newton_step
from snapfit.tracking.kernels.types import F64, I64, U8, Bodies, Structures

_LOCKING_PASSES = 4


@njit(cache=True, nogil=True)
def step_structure(structure: int, structures: Structures, bodies: Bodies, tikhonov: F64) -> None:
    """Newton step of one structure; a failed one leaves all poses and says so in `bodies.solved`.

    A coordinate that would leave its limits is held there, and the step is solved anew for the
    others.
    """
    first, last = structures.starts[structure], structures.starts[structure + 1]
    members = structures.order[first:last]
    n = len(members)
    if n == 0 or bodies.active[members[0]] == 0:
        return
    gradients, hessians = np.empty((n, 6)), np.empty((n, 6, 6))
    adjoints, steps = np.empty((n, 6, 6)), np.empty((n, 6))
    gains, offsets = np.zeros((n, 2, 6)), np.zeros((n, 2))
    locked, change = np.zeros((n, 2), dtype=np.uint8), np.zeros((n, 2))
    places = _places(members, len(bodies.poses))
    for i in range(1, n):
        parent = structures.parents[members[i]]
        relative_adjoint(bodies.poses[parent], bodies.poses[members[i]], adjoints[i])
    solved = False
    for _ in range(_LOCKING_PASSES):
        for i in range(n):
            _take(members[i], bodies, gradients[i], hessians[i])
        for i in range(n - 1, 0, -1):
            body = members[i]
            above = places[structures.parents[body]]
            _eliminate(
                structures.twists[body],
                structures.n_dof[body],
                tikhonov,
                locked[i],
                change[i],
                gradients[i],
                hessians[i],
                gains[i],
                offsets[i],
            )
            _hand_on(adjoints[i], gradients[i], hessians[i], gradients[above], hessians[above])
        solved = newton_step(gradients[0], hessians[0], tikhonov[0], tikhonov[1], steps[0])
        if not solved:
            break
        again = False
        for i in range(1, n):
            body = members[i]
            above = places[structures.parents[body]]
            steps[i] = _times(adjoints[i], steps[above])
            again |= _follow(body, structures, locked[i], gains[i], offsets[i], change[i], steps[i])
        if not again:
            break
    if not solved or not np.isfinite(steps).all():
        for i in range(n):
            bodies.solved[members[i]] = 0
        return
    apply_variation(bodies.poses[members[0]], steps[0])
    for i in range(1, n):
        structures.q[members[i]] += change[i]
        place_child(members[i], structures, bodies.poses)


@njit(cache=True, nogil=True)
def place_child(body: int, structures: Structures, poses: F64) -> None:
    """Pose of a linked body from its parent's and its joint's coordinates, in place."""
    q = structures.q[body]
    twist = q[0] * structures.twists[body, 0] + q[1] * structures.twists[body, 1]
    moved = np.empty((4, 4))
    exponential(twist, moved)
    poses[body] = _product(_product(poses[structures.parents[body]], structures.zeros[body]), moved)


@njit(cache=True, nogil=True)
def relative_adjoint(parent: F64, child: F64, out: F64) -> None:
    """Adjoint (6, 6) of child_from_parent: the child's variation that a parent's brings about.

    Args:
        parent, child: (4, 4) camera_from_body.
        out: written; variations are rotation (rad), then translation (m), on the right.
    """
    rotation = np.empty((3, 3))
    away = np.empty(3)
    for i in range(3):
        for j in range(3):
            rotation[i, j] = (
                child[0, i] * parent[0, j] + child[1, i] * parent[1, j] + child[2, i] * parent[2, j]
            )
        away[i] = (
            child[0, i] * (parent[0, 3] - child[0, 3])
            + child[1, i] * (parent[1, 3] - child[1, 3])
            + child[2, i] * (parent[2, 3] - child[2, 3])
        )
    for j in range(3):
        x, y, z = rotation[0, j], rotation[1, j], rotation[2, j]
        out[3, j] = away[1] * z - away[2] * y
        out[4, j] = away[2] * x - away[0] * z
        out[5, j] = away[0] * y - away[1] * x
        for i in range(3):
            out[i, j] = rotation[i, j]
            out[i + 3, j + 3] = rotation[i, j]
            out[i, j + 3] = 0.0


@njit(cache=True, nogil=True)
def _places(members: I64, n_bodies: int) -> I64:
    """(B,) place of each body among the members; others are not read."""
    places = np.zeros(n_bodies, dtype=np.int64)
    for i in range(len(members)):
        places[members[i]] = i
    return places


@njit(cache=True, nogil=True)
def _take(body: int, bodies: Bodies, gradient: F64, hessian: F64) -> None:
    """A body's own energy; the Hessian of `bodies` has only its lower triangle."""
    for i in range(6):
        gradient[i] = bodies.gradients[body, i] * bodies.active[body]
        for j in range(i + 1):
            value = bodies.hessians[body, i, j] * bodies.active[body]
            hessian[i, j] = value
            hessian[j, i] = value


@njit(cache=True, nogil=True)
def _eliminate(
    twists: F64,
    n_dof: int,
    tikhonov: F64,
    locked: U8,
    change: F64,
    gradient: F64,
    hessian: F64,
    gains: F64,
    offsets: F64,
) -> None:
    """Take a joint's coordinates out of a body's energy, one after the other.

    Afterwards the coordinate d that minimises the energy is `offsets[d] + gains[d] . x`, with x
    the variation that the parent brings about and the coordinates before d. A locked coordinate
    is a given change of the body.

    Args:
        twists: (2, 6), body frame.
        n_dof: coordinates of the joint.
        tikhonov: (2,) of rotation and translation.
        locked, change: (2,) which coordinates are given, and by how much they change then.
        gradient, hessian: (6,) and (6, 6) of the body and what it carries; changed in place.
        gains, offsets: (2, 6) and (2,) written.
    """
    for d in range(n_dof - 1, -1, -1):
        twist = twists[d]
        pull = _times(hessian, twist)
        if locked[d]:
            gradient += pull * change[d]
            gains[d] = 0.0
            offsets[d] = change[d]
            continue
        turns = twist[0] != 0.0 or twist[1] != 0.0 or twist[2] != 0.0
        stiffness = np.dot(twist, pull) + tikhonov[0 if turns else 1]
        slope = np.dot(twist, gradient)
        gains[d] = -pull / stiffness
        offsets[d] = -slope / stiffness
        gradient -= pull * (slope / stiffness)
        for i in range(6):
            for j in range(6):
                hessian[i, j] -= pull[i] * pull[j] / stiffness


@njit(cache=True, nogil=True)
def _hand_on(
    adjoint: F64, gradient: F64, hessian: F64, parent_gradient: F64, parent_hessian: F64
) -> None:
    """Add what is left of a body's energy to its parent's."""
    half = np.zeros((6, 6))
    for i in range(6):
        for k in range(6):
            for j in range(6):
                half[i, j] += hessian[i, k] * adjoint[k, j]
    for k in range(6):
        for i in range(6):
            parent_gradient[i] += adjoint[k, i] * gradient[k]
            for j in range(6):
                parent_hessian[i, j] += adjoint[k, i] * half[k, j]


@njit(cache=True, nogil=True)
def _follow(
    body: int,
    structures: Structures,
    locked: U8,
    gains: F64,
    offsets: F64,
    change: F64,
    step: F64,
) -> bool:
    """The joint's part of a body's step, in place; true where a coordinate had to be locked."""
    again = False
    for d in range(structures.n_dof[body]):
        change[d] = offsets[d] + np.dot(gains[d], step)
        low, high = structures.limits[body, d]
        value = structures.q[body, d] + change[d]
        if not locked[d] and not low <= value <= high:
            locked[d] = 1
            change[d] = min(max(value, low), high) - structures.q[body, d]
            again = True
        step += structures.twists[body, d] * change[d]
    return again


@njit(cache=True, nogil=True)
def _times(matrix: F64, vector: F64) -> F64:
    result = np.zeros(6)
    for i in range(6):
        for j in range(6):
            result[i] += matrix[i, j] * vector[j]
    return result


@njit(cache=True, nogil=True)
def _product(a: F64, b: F64) -> F64:
    """Product of two poses (4, 4)."""
    out = np.zeros((4, 4))
    out[3, 3] = 1.0
    for i in range(3):
        for j in range(4):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]
        out[i, 3] += a[i, 3]
    return out
