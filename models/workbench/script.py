"""A script of the bench: which part moves when, where it lies before, and the states passed.

World frame: the bench's top is z = 0, x points to the right of the camera, y away from it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.motion import Motion

_STABLE_M = 1e-5


@dataclass(frozen=True)
class Place:
    """How a part lies on the bench at first.

    Attributes:
        x_m, y_m: where its origin stands.
        yaw_deg: turn about the vertical.
        down: direction of the body that points down; the nearest stable side is taken.
    """

    x_m: float
    y_m: float
    yaw_deg: float
    down: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Move:
    """One part's motion in the script.

    Attributes:
        part: its name.
        start_s: when it starts.
        duration_s: how long it takes.
        motion: where it is meanwhile.
        carried: `part_from_other` of what is joined to it and moves as one with it.
    """

    part: str
    start_s: float
    duration_s: float
    motion: Motion
    carried: Mapping[str, Pose] = field(default_factory=dict)

    @property
    def end_s(self) -> float:
        """When the part has come to its place."""
        return self.start_s + self.duration_s


@dataclass(frozen=True, eq=False)
class Script:
    """An assembly from the first frame to the last.

    Attributes:
        initial: `world_from_part` at the start.
        moves: one after the other.
        states: (time from which it holds, s; name), the first at 0.
        duration_s: with the rest at the end.
    """

    initial: Mapping[str, Pose]
    moves: tuple[Move, ...]
    states: tuple[tuple[float, str], ...]
    duration_s: float

    def poses_at(self, time_s: float) -> dict[str, Pose]:
        """`world_from_part` of every part."""
        found: dict[str, Pose] = {}
        # Of the moves of a part only the last that has begun counts.
        for move in reversed(self.moves):
            if time_s < move.start_s or (
                move.part in found and found.keys() >= move.carried.keys()
            ):
                continue
            share = (time_s - move.start_s) / move.duration_s
            pose = move.motion.at(min(share, 1.0))
            found.setdefault(move.part, pose)
            for name, part_from_other in move.carried.items():
                found.setdefault(name, pose @ part_from_other)
        return {name: found.get(name, pose) for name, pose in self.initial.items()}

    def state_at(self, time_s: float) -> str:
        """Name of the assembly state."""
        return next(name for start, name in reversed(self.states) if time_s >= start - 1e-9)

    def moving_at(self, time_s: float) -> tuple[str, ...]:
        """The part that moves and all that it carries; at rest, those that moved last or will."""
        begun = [move for move in self.moves if move.start_s <= time_s]
        move = begun[-1] if begun else self.moves[0]
        return (move.part, *sorted(move.carried))

    def rest_at(self, time_s: float) -> int | None:
        """How many moves are done while nothing moves; None while something does."""
        if any(move.start_s < time_s < move.end_s for move in self.moves):
            return None
        return sum(move.end_s <= time_s for move in self.moves)

    def slowed(self, factor: float) -> Script:
        """The same, taking longer by a factor."""
        moves = [
            replace(each, start_s=each.start_s * factor, duration_s=each.duration_s * factor)
            for each in self.moves
        ]
        states = [(start_s * factor, name) for start_s, name in self.states]
        return Script(self.initial, tuple(moves), tuple(states), self.duration_s * factor)


def resting_pose(mesh: Mesh, place: Place) -> Pose:
    """`world_from_body` of a part that lies stably, on the side that is nearest to `place.down`."""
    side = _stable_side(mesh, np.array(place.down, dtype=np.float64))
    level = _rotation_between(side, np.array([0.0, 0.0, -1.0]))
    yaw = Pose.exp([0, 0, math.radians(place.yaw_deg), 0, 0, 0]).rotation
    rotation = yaw @ level
    height_m = -float((mesh.vertices @ rotation[2]).min())
    return Pose.from_rotation_translation(rotation, (place.x_m, place.y_m, height_m))


def _stable_side(mesh: Mesh, down: Array) -> Array:
    """(3,) outward normal of a side of the hull above which the centre of mass stands."""
    normals, is_stable = _sides(mesh)
    best, best_score = normals[0], -math.inf
    for normal in normals[is_stable]:
        score = float(normal @ down)
        if score > best_score:
            best, best_score = normal, score
    return np.array(best)


@lru_cache(maxsize=64)
def _sides(mesh: Mesh) -> tuple[Array, npt.NDArray[np.bool_]]:
    """(F, 3) outward normals of the hull's sides, and (F,) on which of them it lies stably."""
    import trimesh

    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    hull, center = solid.convex_hull, solid.center_mass
    normals = hull.face_normals
    heights = np.einsum("ij,ij->i", normals, hull.triangles[:, 0])
    feet = (
        center + normal * (height - normal @ center)
        for normal, height in zip(normals, heights, strict=True)
    )
    is_stable = [(normals @ foot <= heights + _STABLE_M).all() for foot in feet]
    return np.array(normals), np.array(is_stable, dtype=np.bool_)


def _rotation_between(a: Array, b: Array) -> Array:
    """The smallest rotation that turns the direction a into b."""
    cross, cosine = np.cross(a, b), float(a @ b)
    sine = float(np.linalg.norm(cross))
    if sine < 1e-9:
        flip = math.pi if cosine < 0 else 0.0
        return Pose.exp([flip, 0, 0, 0, 0, 0]).rotation
    return Pose.exp([*(cross / sine * math.atan2(sine, cosine)), 0, 0, 0]).rotation
