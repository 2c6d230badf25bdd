"""Which bodies are linked, and by which joints: the structures that the optimiser moves as one."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from snapfit.models.joint import JointMotion
from snapfit.models.pose import Array, Pose
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.kernels.structure import place_child
from snapfit.tracking.kernels.types import Structures


class KinematicStructures:
    """Trees of bodies and joints (Mb-ICG); a body without a link is a tree of one.

    Attributes:
        arrays: as the kernels take them.
    """

    def __init__(self, n_bodies: int) -> None:
        """All bodies free."""
        self.arrays = Structures(
            parents=np.full(n_bodies, -1, dtype=np.int64),
            order=np.arange(n_bodies, dtype=np.int64),
            starts=np.arange(n_bodies + 1, dtype=np.int64),
            zeros=np.tile(np.eye(4), (n_bodies, 1, 1)),
            twists=np.zeros((n_bodies, 2, 6)),
            n_dof=np.zeros(n_bodies, dtype=np.int64),
            q=np.zeros((n_bodies, 2)),
            limits=np.tile([-np.inf, np.inf], (n_bodies, 2, 1)),
        )
        # Asked for several times a frame and body; changed with the links alone.
        self._members = [self.arrays.order[body : body + 1] for body in range(n_bodies)]

    def parent(self, body: int) -> int | None:
        """The body that carries it, None where it is free."""
        parent = int(self.arrays.parents[body])
        return None if parent < 0 else parent

    def root(self, body: int) -> int:
        """The body that carries all others of its structure."""
        while (parent := self.parent(body)) is not None:
            body = parent
        return body

    def members(self, body: int) -> npt.NDArray[np.int64]:
        """All bodies of the structure that a body is in, parents before children."""
        return self._members[body]

    def link(self, child: int, parent: int, joint: JointMotion, q: Array) -> None:
        """Let a parent carry a child; the poses stay, see `place`.

        Args:
            child, parent: indices of bodies.
            joint: between them.
            q: (n_dof,) its coordinates; clipped to the limits.

        Raises:
            TrackingError: the child has a parent, or is the parent's own root.
        """
        if self.parent(child) is not None or self.root(parent) == child:
            raise TrackingError(f"body {child} cannot be linked to body {parent}: it is no root")
        arrays, n = self.arrays, joint.n_dof
        arrays.parents[child] = parent
        arrays.zeros[child] = joint.zero.matrix
        arrays.twists[child] = 0.0
        arrays.twists[child, :n] = joint.twists
        arrays.n_dof[child] = n
        arrays.q[child] = 0.0
        arrays.q[child, :n] = np.clip(q, joint.limits[:, 0], joint.limits[:, 1])
        arrays.limits[child] = (-np.inf, np.inf)
        arrays.limits[child, :n] = joint.limits
        self._order()

    def unlink(self, child: int) -> None:
        """Set a child free; what it carries stays on it."""
        self.arrays.parents[child] = -1
        self.arrays.n_dof[child] = 0
        self.arrays.q[child] = 0.0
        self._order()

    def place(self, body: int, poses: Array) -> None:
        """Put all that a body carries where its links want it.

        Args:
            body: whose pose stays.
            poses: (B, 4, 4) camera_from_body, changed in place.
        """
        members = list(self.members(body))
        carried = {body}
        for member in members:
            if self.parent(int(member)) in carried:
                place_child(member, self.arrays, poses)
                carried.add(int(member))

    def parent_from_child(self, child: int) -> Pose:
        """Where a linked child now stands on its parent."""
        arrays = self.arrays
        return Pose(arrays.zeros[child]) @ Pose.exp(arrays.q[child] @ arrays.twists[child])

    def _order(self) -> None:
        """Bodies by structure, parents before their children."""
        arrays = self.arrays
        n = len(arrays.parents)
        order: list[int] = []
        starts: list[int] = []
        for root in np.flatnonzero(arrays.parents < 0):
            starts.append(len(order))
            tree = [int(root)]
            for body in tree:
                tree += [int(child) for child in np.flatnonzero(arrays.parents == body)]
            order += tree
            for body in tree:
                self._members[body] = arrays.order[starts[-1] : starts[-1] + len(tree)]
        arrays.order[:] = order
        arrays.starts[:] = n
        arrays.starts[: len(starts)] = starts
