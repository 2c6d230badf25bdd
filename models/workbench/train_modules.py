"""Parts as they turn up in a training image: joined as some state has them, or each on its own."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull

from snapfit.models.asset import Asset, Part
from snapfit.models.keypoints import surface_samples
from snapfit.models.manifest import Joint, JointType, Link
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.mounting import joined

Rng = np.random.Generator

_POINTS = 900
_AT_REST_SHARE, _LONGEST_TRAVEL_M = 0.4, 0.05
_MISSING_SHARE, _TWICE_SHARE = 0.12, 0.1


@dataclass(frozen=True, eq=False)
class Module:
    """Parts that move as one.

    Attributes:
        parts: with the pose `module_from_part` of each.
        points: (N, 3) of its surface, module's frame, m.
    """

    parts: tuple[tuple[Part, Pose], ...]
    points: Array

    def scaled(self, factor: float) -> Module:
        """A larger or smaller one, of one part."""
        ((part, pose),) = self.parts
        mesh = Mesh(part.mesh.vertices * np.float32(factor), part.mesh.faces)
        larger = Module(((replace(part, mesh=mesh), pose),), self.points * factor)
        # Its sides are the same: what takes time is done once.
        larger.__dict__["rest_sides"] = self.rest_sides
        return larger

    @cached_property
    def rest_sides(self) -> tuple[Array, Array]:
        """(F, 3) directions that may point down when it lies, and (F,) their shares."""
        hull = ConvexHull(self.points)
        corners = self.points[hull.simplices]
        area = np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        # Faces of one plane count together, so that a large flat side is taken most often.
        key = np.round(hull.equations[:, :3] * 12).astype(int)
        _, group = np.unique(key, axis=0, return_inverse=True)
        total = np.bincount(group.ravel(), area)[group.ravel()]
        share = area * total
        return hull.equations[:, :3], share / share.sum()


class Modules:
    """The modules that an asset's parts can make."""

    def __init__(self, asset: Asset) -> None:
        self._parts = {part.name: part for part in asset.parts}
        rng = np.random.default_rng(0)
        self._points = {
            part.name: np.vstack(
                [surface_samples(part.mesh, _POINTS, rng)[0], part.mesh.vertices[:: _every(part)]]
            )
            for part in asset.parts
        }
        self._single = {
            part.name: Module(((part, Pose.identity()),), self._points[part.name])
            for part in asset.parts
        }
        self._states = [(state.name, state.links) for state in asset.states if state.links]

    @property
    def can_be_assembled(self) -> bool:
        """Whether there is a state in which parts are joined."""
        return bool(self._states)

    def sampled(self, assembled: bool, rng: Rng) -> tuple[list[Module], str | None]:
        """Modules for one image, and the state that they are in; None if all are apart.

        Of joined parts, all are there; of others, now and then one is missing or there twice.
        """
        state: str | None = None
        links: tuple[Link, ...] = ()
        if assembled:
            state, links = self._states[int(rng.integers(len(self._states)))]
        moved = [_moved(link, rng) for link in links]
        modules: list[Module] = []
        waiting = list(self._parts)
        linked = {name for link in moved for name in (link.parent, link.child)}
        while waiting:
            name = waiting[0]
            poses = joined(name, moved)
            waiting = [each for each in waiting if each not in poses]
            if name not in linked and rng.random() < _MISSING_SHARE and (modules or waiting):
                continue
            modules.append(self._module(poses))
            if len(poses) == 1 and rng.random() < _TWICE_SHARE:
                modules.append(self._module(poses))
        return modules, state

    def _module(self, poses: Mapping[str, Pose]) -> Module:
        if len(poses) == 1:
            return self._single[next(iter(poses))]
        points = [pose.transform(self._points[name]) for name, pose in poses.items()]
        parts = tuple((self._parts[name], pose) for name, pose in poses.items())
        return Module(parts, np.vstack(points))


def _every(part: Part) -> int:
    return max(1, len(part.mesh.vertices) // _POINTS)


def _moved(link: Link, rng: Rng) -> Link:
    """A link whose joint stands somewhere within its limits; often where it ends up."""
    if link.joint.type is JointType.FIXED or rng.random() < _AT_REST_SHARE:
        return link
    pose = link.parent_from_child @ _free_motion(link.joint, rng)
    return link.model_copy(update={"parent_from_child": pose})


def _free_motion(joint: Joint, rng: Rng) -> Pose:
    """A motion of the child, in its own frame, that the joint leaves free."""
    axis = np.array(joint.axis, dtype=np.float64)
    axis = axis / np.linalg.norm(axis)
    travel_m = turn_rad = 0.0
    if joint.type.slides:
        limits = joint.travel_m or (-_LONGEST_TRAVEL_M, 0.0)
        travel_m = float(rng.uniform(*np.clip(limits, -_LONGEST_TRAVEL_M, _LONGEST_TRAVEL_M)))
    if joint.type is JointType.SCREW and joint.pitch_m:
        turn_rad = 2 * math.pi * travel_m / joint.pitch_m
    elif joint.type.turns:
        turn_rad = math.radians(rng.uniform(*(joint.turn_deg or (-180.0, 180.0))))
    rotation = Pose.exp([*(axis * turn_rad), 0, 0, 0]).rotation
    point = np.array(joint.point_m)
    shift = point - rotation @ point + travel_m * axis
    return Pose.from_rotation_translation(rotation, shift)


def resting(module: Module, rng: Rng) -> Pose:
    """`world_from_module` that lies on the bench (z = 0) above the origin, on some side."""
    sides, shares = module.rest_sides
    down = sides[int(rng.choice(len(sides), p=shares))]
    turn = Pose.from_rotation_translation(_turned_down(down), np.zeros(3))
    yaw = Pose.exp([0, 0, rng.uniform(0, 2 * math.pi), 0, 0, 0])
    points = (yaw @ turn).transform(module.points)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2
    return Pose.from_translation(-middle[0], -middle[1], -low[2]) @ yaw @ turn


def afloat(module: Module, rng: Rng) -> Pose:
    """`world_from_module` turned anyhow, its middle at the origin: in somebody's hand."""
    quaternion = rng.standard_normal(4)
    turn = Pose.from_quaternion(quaternion, (0, 0, 0))
    points = turn.transform(module.points)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return Pose.from_translation(*(-middle)) @ turn


def _turned_down(direction: Array) -> Array:
    """(3, 3) rotation that brings a unit direction to (0, 0, -1)."""
    axis = np.cross(direction, (0.0, 0.0, -1.0))
    sine, cosine = float(np.linalg.norm(axis)), -float(direction[2])
    if sine < 1e-9:
        return np.eye(3) if cosine > 0 else np.diag([1.0, -1.0, -1.0])
    return Pose.exp([*(axis / sine * math.atan2(sine, cosine)), 0, 0, 0]).rotation


class Space:
    """The room above the bench in cells that are taken or free, so that nothing is in another."""

    _CELL_M, _HALF_M, _HIGH_M = 0.007, 0.66, 0.42

    def __init__(self, gap: bool) -> None:
        n = math.ceil(2 * self._HALF_M / self._CELL_M)
        self._taken = np.zeros((n, n, math.ceil(self._HIGH_M / self._CELL_M) + 2), dtype=bool)
        self._gap = gap

    def take(self, points: Array) -> bool:
        """Takes the cells of points (N, 3), world frame, m; False if one is taken or outside."""
        cells = np.floor(points / self._CELL_M).astype(np.intp)
        cells[:, :2] += self._taken.shape[0] // 2
        cells[:, 2] += 1
        top = np.array(self._taken.shape)
        if (cells < 1).any() or (cells >= top - 1).any():
            return False
        x, y, z = cells.T
        if self._taken[x, y, z].any():
            return False
        steps: Sequence[int] = (-1, 0, 1) if self._gap else (0,)
        for dx in steps:
            for dy in steps:
                for dz in steps:
                    self._taken[x + dx, y + dy, z + dz] = True
        return True
