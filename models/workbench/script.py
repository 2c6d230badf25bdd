"""The scripted assembly: which part moves when, where it lies before, and the states passed.

World frame: the bench's top is z = 0, x points to the right of the camera, y away from it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from snapfit.models.asset import Asset
from snapfit.models.errors import WorkbenchError
from snapfit.models.manifest import JointType, Link
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.motion import Carry, Motion, Slide, Tremor, Twist

_REST_S, _PAUSE_S = 1.0, 0.25
_TWIST_S = 0.85
_LARGEST_TWIST_RAD = math.radians(100)
_DROP_M = 0.03
_CLEARANCE_M = 0.012
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


# The part that carries the others, where it lies first and where it is put; then the others.
_BASE_FROM = Place(0.045, 0.075, 62.0, (0, 0, -1))
_BASE_TO = Place(0.025, 0.0, 24.0, (0, 0, -1))
_OTHERS = (Place(0.185, -0.06, 50.0, (0, 1, 0)), Place(-0.175, -0.05, 85.0, (0, -1, 0)))
_BASE_S, _CARRY_S, _SLIDE_S, _INSERT_S = 1.4, 2.8, 0.6, 3.0


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

    def active_at(self, time_s: float) -> str:
        """Name of the part that moves; at rest, of the one that moved last or will move first."""
        begun = [move for move in self.moves if move.start_s <= time_s]
        return (begun[-1] if begun else self.moves[0]).part

    def rest_at(self, time_s: float) -> int | None:
        """How many moves are done while nothing moves; None while something does."""
        if any(move.start_s < time_s < move.end_s for move in self.moves):
            return None
        return sum(move.end_s <= time_s for move in self.moves)


class _Writer:
    """Puts moves one after the other."""

    def __init__(self, initial: dict[str, Pose], first_state: str, rng: np.random.Generator):
        self.initial = dict(initial)
        self.now = dict(initial)
        self.time_s = _REST_S
        self.moves: list[Move] = []
        self.states = [(0.0, first_state)]
        self.rng = rng

    def add(self, part: str, duration_s: float, motion: Motion) -> None:
        self.moves.append(Move(part, self.time_s, duration_s, motion))
        self.now[part] = motion.at(1.0)
        self.time_s += duration_s

    def carry(
        self, part: str, duration_s: float, goal: Pose, lift_m: float, approach_m: Array
    ) -> None:
        lift = np.array([0, 0, lift_m])
        tremor = Tremor.sampled(self.rng, duration_s)
        bend_m = max(0.8 * lift_m, 0.02)
        motion = Carry(self.now[part], goal, lift, approach_m, bend_m, tremor)
        self.add(part, duration_s, motion)

    def finish(self) -> Script:
        return Script(self.initial, tuple(self.moves), tuple(self.states), self.time_s + _REST_S)


def assembly_script(asset: Asset, rng: np.random.Generator) -> Script:
    """The assembly of an asset, step after step of its graph.

    Raises:
        WorkbenchError: no assembly graph, more parts than there are places on the bench, or a
            step whose joint is neither prismatic nor a screw.
    """
    if not asset.steps or len(asset.parts) > 1 + len(_OTHERS):
        raise WorkbenchError(
            f"the workbench assembles assets with steps and up to {1 + len(_OTHERS)} parts; "
            f"{asset.name!r} has {len(asset.steps)} steps and {len(asset.parts)} parts"
        )
    states = {state.name: state for state in asset.states}
    carrier = states[asset.steps[0].to_state].links[0].parent
    meshes = {part.name: part.mesh for part in asset.parts}
    others = [name for name in meshes if name != carrier]
    initial = {carrier: resting_pose(meshes[carrier], _BASE_FROM)}
    for name, place in zip(others, _OTHERS, strict=False):
        initial[name] = resting_pose(meshes[name], place)
    writer = _Writer({name: initial[name] for name in meshes}, asset.states[0].name, rng)
    goal = resting_pose(meshes[carrier], _BASE_TO)
    writer.carry(carrier, _BASE_S, goal, 0.035, np.array([0, 0, 0.004]))
    for step in asset.steps:
        writer.time_s += _PAUSE_S
        mounted = {link.child for link in states[step.from_state].links}
        for link in states[step.to_state].links:
            if link.child not in mounted:
                _mount(writer, link, meshes[link.child])
        writer.states.append((writer.time_s, step.to_state))
    return writer.finish()


def _mount(writer: _Writer, link: Link, mesh: Mesh) -> None:
    """Brings a part to where its joint begins, and then along its joint."""
    place = writer.now[link.parent] @ link.parent_from_child
    joint = link.joint
    axis = np.array(joint.axis if joint.axis else (0, 0, 0), dtype=np.float64)
    from_m = joint.travel_m[0] if joint.travel_m else 0.0
    if joint.type is JointType.PRISMATIC:
        begin = place @ Pose.from_translation(*(from_m * axis))
        writer.carry(link.child, _CARRY_S, begin, 0.11, np.array([0, 0, _DROP_M]))
        writer.add(link.child, _SLIDE_S, Slide(begin, place))
    elif joint.type is JointType.SCREW and joint.pitch_m:
        turn_rad = -from_m / joint.pitch_m * 2 * math.pi
        n_twists = math.ceil(turn_rad / _LARGEST_TWIST_RAD)
        twist = Twist(place, axis, turn_rad, joint.pitch_m, n_twists)
        begin = twist.at(0.0)
        # Far enough back along the axis that the tip is outside of what it goes into.
        reach_m = float(np.ptp(mesh.vertices @ axis)) / 2 + _CLEARANCE_M
        approach_m = -reach_m * (place.rotation @ axis)
        writer.carry(link.child, _INSERT_S, begin, 0.09, approach_m)
        writer.time_s += _PAUSE_S / 2
        writer.add(link.child, n_twists * _TWIST_S, twist)
    else:
        raise WorkbenchError(
            f"the workbench mounts prismatic and screw joints, {link.child!r} has a {joint.type}"
        )


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
    import trimesh

    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    hull = solid.convex_hull
    normals, heights = (
        hull.face_normals,
        np.einsum("ij,ij->i", hull.face_normals, hull.triangles[:, 0]),
    )
    best, best_score = normals[0], -math.inf
    for normal, height in zip(normals, heights, strict=True):
        foot = solid.center_mass + normal * (height - normal @ solid.center_mass)
        score = float(normal @ down)
        if score > best_score and (normals @ foot <= heights + _STABLE_M).all():
            best, best_score = normal, score
    return np.array(best)


def _rotation_between(a: Array, b: Array) -> Array:
    """The smallest rotation that turns the direction a into b."""
    cross, cosine = np.cross(a, b), float(a @ b)
    sine = float(np.linalg.norm(cross))
    if sine < 1e-9:
        flip = math.pi if cosine < 0 else 0.0
        return Pose.exp([flip, 0, 0, 0, 0, 0]).rotation
    return Pose.exp([*(cross / sine * math.atan2(sine, cosine)), 0, 0, 0]).rotation
