"""The bundled assets: what each must keep, and how tests lay hands on their solids."""

import functools
import importlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import ModuleType

import numpy as np

from snapfit.models.asset import Asset, Part, find_asset
from snapfit.models.assets.solids import Solid
from snapfit.models.manifest import Joint, JointType, Link
from snapfit.models.pose import Pose

LARGEST_OVERLAP_MM3 = 0.1


@dataclass(frozen=True)
class Kept:
    """What an asset must keep."""

    base: str  # the part that stands on no other
    extents_mm: Mapping[str, tuple[float, float, float]]
    joints: Mapping[str, str]  # of the assembled product: child -> type
    states: tuple[str, ...] | None  # None: the names are free, the count is that of `n_links`
    n_links: tuple[int, ...]  # of each state
    n_faces: tuple[int, int] = (1000, 10_000)
    meshes: Mapping[str, str] = field(default_factory=dict)  # of parts that share one
    misfit: float = 5e-4  # between bundle and script, share of the volume
    untracked: frozenset[str] = frozenset()
    frame: frozenset[str] = frozenset()  # links that decide in later states too
    # Symmetric parts: axes of the turns and their number in a whole turn.
    turns: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    round_to_mm: Mapping[str, float] = field(default_factory=dict)  # round about z but for a thread
    least_common: float = 0.999  # share of the volume after a turn of the symmetry
    most_common: float = 0.97  # after any other
    least_deviation_mm: float = 2.5  # after any other
    note_within_mm: float = 6.0  # of the surface of its part
    noted_beside: frozenset[str] = frozenset()  # parts of notes that their step does not name


KEPT = {
    "hobby-corner-clamp": Kept(
        base="base",
        extents_mm={"base": (160, 99, 54), "jaw": (85, 64, 53), "bolt": (59, 53, 131)},
        joints={"jaw": "prismatic", "bolt": "screw"},
        states=("parts-free", "jaw-mounted", "assembled"),
        n_links=(0, 1, 2),
        n_faces=(2500, 20_000),
        frame=frozenset({"jaw"}),
        turns={"bolt": ("z", 3)},
        least_common=0.9999,
        most_common=0.9,
        note_within_mm=9.5,
        noted_beside=frozenset({"jaw"}),
    ),
    "geared-caliper": Kept(
        base="move-bottom",
        extents_mm={
            "fix": (207, 5, 110),
            "move-bottom": (90, 110, 17),
            "move-top-vernier": (65, 17, 46),
            "gear-large": (37.89, 37.89, 4.8),
            "gear-small": (13.89, 13.89, 7.1),
            "roller": (21.89, 21.89, 10.1),
        },
        joints={
            "fix": "prismatic",
            "move-top-vernier": "fixed",
            "gear-large": "revolute",
            "gear-small": "revolute",
            "roller": "revolute",
        },
        states=("parts-free", "beam-in-slide", "assembled"),
        n_links=(0, 1, 5),
        untracked=frozenset({"gear-large", "gear-small", "roller"}),
        frame=frozenset({"fix"}),
        turns={"gear-large": ("z", 6), "roller": ("z", 4)},
        most_common=0.995,
        least_deviation_mm=0.5,
    ),
    "liftpod": Kept(
        base="base-plate",
        extents_mm={
            "arm-first": (115, 20, 8),
            "arm-last": (140, 20, 8),
            "bar": (143, 15, 11),
            "base-plate": (124, 90, 26),
            "clamp-frame": (70, 80, 20),
            "clamp-slider": (52, 46, 20),
            "sleeve": (20, 20, 72),
        },
        joints={
            "arm-first": "revolute",
            "arm-last": "revolute",
            "bar": "revolute",
            "sleeve": "prismatic",
            "clamp-frame": "revolute",
            "clamp-slider": "prismatic",
        },
        states=None,
        n_links=tuple(range(7)),
        frame=frozenset({"arm-first", "arm-last", "bar", "sleeve", "clamp-frame"}),
        turns={
            **dict.fromkeys(("arm-first", "arm-last", "bar", "sleeve"), ("xyz", 2)),
            "base-plate": ("z", 2),
        },
    ),
    "nano-chuck": Kept(
        base="base",
        extents_mm={
            "base": (165, 82, 40),
            "screw": (58, 58, 131),
            "headplate": (44, 44, 16),
            "balljoint": (36, 36, 57),
            "nut": (59, 59, 25),
            "vise-base": (80, 108, 77),
            "vise-slider": (80, 47, 26),
            "vise-screw": (34, 34, 104),
        },
        joints={
            "screw": "screw",
            "headplate": "revolute",
            "balljoint": "fixed",
            "nut": "screw",
            "vise-base": "screw",
            "vise-slider": "prismatic",
            "vise-screw": "screw",
        },
        states=None,
        n_links=tuple(range(8)),
        misfit=1e-3,
        frame=frozenset({"balljoint", "vise-base", "vise-slider"}),
        turns={"screw": ("z", 4), "headplate": ("z", 4), "nut": ("z", 8)},
        round_to_mm={"balljoint": 1.2, "vise-screw": 1.0},
        note_within_mm=19.0,
    ),
    "hand-screw-clamp": Kept(
        base="jaw-1",
        extents_mm={
            "jaw-1": (182, 38, 61),
            "jaw-2": (182, 38, 61),
            "knob-1": (59, 59, 41),
            "knob-2": (59, 59, 41),
            "pad": (51, 51, 45),
            "thread-1": (31, 178, 15),
            "thread-2": (31, 178, 15),
        },
        joints={
            "pad": "fixed",
            "thread-1": "prismatic",
            "thread-2": "prismatic",
            "jaw-2": "prismatic",
            "knob-1": "screw",
            "knob-2": "screw",
        },
        states=None,
        n_links=tuple(range(7)),
        meshes={f"{name}-{i}": name for name in ("knob", "thread") for i in (1, 2)},
        misfit=1e-3,
        frame=frozenset({"pad", "jaw-2"}),
        turns={
            **dict.fromkeys(("knob-1", "knob-2"), ("z", 4)),
            **dict.fromkeys(("thread-1", "thread-2"), ("y", 2)),
        },
        note_within_mm=11.0,
    ),
}


@dataclass(frozen=True, eq=False)
class Bundle:
    """A bundled asset with the script that makes it."""

    script: ModuleType
    asset: Asset
    meshes: Mapping[str, Solid]  # as the script makes them, millimetres
    solids: Mapping[str, Solid]  # of each part, millimetres

    @property
    def parts(self) -> dict[str, Part]:
        return {part.name: part for part in self.asset.parts}

    def links(self, state: str = "assembled") -> dict[str, Link]:
        found = next(found for found in self.asset.states if found.name == state)
        return {link.child: link for link in found.links}

    def placed(self) -> dict[str, Solid]:
        """The solids of the assembled product, in the frame of its base."""
        links = self.links()
        return {name: moved(solid, base_from(name, links)) for name, solid in self.solids.items()}


@functools.cache
def load_bundle(name: str) -> Bundle:
    script = importlib.import_module(f"snapfit.models.assets.{name.replace('-', '_')}")
    meshes, kept = script.parts(), KEPT[name]
    solids = {part: meshes[kept.meshes.get(part, part)] for part in kept.extents_mm}
    return Bundle(script, find_asset(name), meshes, solids)


def moved(solid: Solid, pose: Pose) -> Solid:
    """A solid in millimetres after a motion in metres."""
    matrix = pose.matrix[:3].copy()
    matrix[:, 3] *= 1000
    return solid.transform(matrix)


def base_from(name: str, links: Mapping[str, Link]) -> Pose:
    if name not in links:
        return Pose.identity()
    return base_from(links[name].parent, links) @ links[name].parent_from_child


def along(joint: Joint, share: float) -> Pose:
    """`child_from_child` at a share of the joint's range, screws turning as they go."""
    axis = np.array(joint.axis)
    if joint.type is JointType.REVOLUTE:
        low, high = joint.turn_deg or (-180.0, 180.0)
        turn = turned(axis, math.radians(low + share * (high - low)))
        point = np.array(joint.point_m)
        return Pose.from_rotation_translation(turn.rotation, point - turn.rotation @ point)
    low, high = joint.travel_m
    travel_m = low + share * (high - low)
    turn_rad = 2 * math.pi * travel_m / joint.pitch_m if joint.type is JointType.SCREW else 0.0
    return Pose.exp([*(turn_rad * axis), *(travel_m * axis)])


def turned(axis: str | Iterable[float], angle_rad: float) -> Pose:
    """A turn about a line through the origin: x, y, z or a unit vector."""
    direction = np.eye(3)["xyz".index(axis)] if isinstance(axis, str) else np.asarray(axis)
    return Pose.exp([*(angle_rad * direction), 0, 0, 0])
