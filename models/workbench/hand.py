"""A right hand with its forearm: rigid bones under round flesh, moved by joint angles.

Hand frame: the palm's middle is the origin, x points to the fingertips, y to the thumb's side, z
out of the back of the hand. Sizes are those of an adult.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.spatial import ConvexHull

from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose

Rgb = tuple[int, int, int]

SKINS_RGB: tuple[Rgb, ...] = (
    (226, 176, 148),
    (205, 146, 112),
    (168, 112, 80),
    (112, 72, 52),
    (236, 192, 172),
)
SLEEVES_RGB: tuple[Rgb, ...] = ((52, 64, 84), (96, 98, 100), (120, 44, 40), (58, 74, 56))

# Knuckle (x, y, z), lengths of the three bones, radii at their four ends, outward turn (deg); mm.
_FINGERS = (
    ((42, 30, 2), (42, 25, 20), (10.2, 9.0, 8.0, 6.8), 5.0),
    ((46, 10, 3), (46, 29, 21), (10.4, 9.2, 8.2, 7.0), 0.0),
    ((41, -10, 2), (42, 27, 21), (9.8, 8.6, 7.8, 6.6), -4.0),
    ((32, -28, 0), (33, 20, 18), (8.8, 7.6, 6.8, 5.8), -9.0),
)
_FLEXION_DEG = (58.0, 66.0, 42.0)
_WRIST_X, _SLEEVE_X, _ELBOW_X = -52.0, -190.0, -700.0
# Points of a ball, and the radius from which it is a fine one.
_COARSE, _FINE, _FINE_MM = 160, 700, 18.0


@dataclass(frozen=True, eq=False)
class Body:
    """A thing that is drawn and moves.

    Attributes:
        mesh: metres, its own frame.
        world_from_body: where it is.
        color_rgb: sRGB, 0 to 255.
        gloss: strength of the highlight.
    """

    mesh: Mesh
    world_from_body: Pose
    color_rgb: Rgb
    gloss: float


@dataclass(frozen=True)
class Person:
    """Whose hand it is: colours of skin and sleeve."""

    skin_rgb: Rgb
    sleeve_rgb: Rgb

    @staticmethod
    def sampled(rng: np.random.Generator) -> Person:
        """Somebody."""
        skin = SKINS_RGB[int(rng.integers(len(SKINS_RGB)))]
        return Person(skin, SLEEVES_RGB[int(rng.integers(len(SLEEVES_RGB)))])


def hand_bodies(
    world_from_hand: Pose, curl: float, person: Person, shoulder_m: Array
) -> list[Body]:
    """The hand in one posture.

    Args:
        world_from_hand: where the palm is.
        curl: 0 is flat, 1 is a fist.
        person: whose it is.
        shoulder_m: (3,) where the arm comes from, world frame; the wrist bends as it must.
    """
    skin = person.skin_rgb
    arm = _bent_wrist(world_from_hand, shoulder_m)
    bodies = [Body(mesh, world_from_hand, skin, 0.10) for mesh in (_palm(), _heel())]
    bodies.append(Body(_forearm(), arm, skin, 0.10))
    bodies.append(Body(_sleeve(), arm, person.sleeve_rgb, 0.0))
    for knuckle, lengths, radii, outward_deg in _FINGERS:
        bodies += _finger(world_from_hand, (knuckle, lengths, radii, outward_deg), curl, skin)
    return bodies + _thumb(world_from_hand, curl, skin)


def _bent_wrist(palm: Pose, shoulder_m: Array) -> Pose:
    """`world_from_arm`: the palm's frame turned about the wrist so that the arm lines up."""
    wrist = Pose.from_translation(_WRIST_X * 0.001, 0, 0)
    joint = palm @ wrist
    x = joint.translation - shoulder_m
    x = x / np.linalg.norm(x)
    z = joint.rotation[:, 2] - (joint.rotation[:, 2] @ x) * x
    z = z / max(float(np.linalg.norm(z)), 1e-6)
    rotation = np.column_stack([x, np.cross(z, x), z])
    return Pose.from_rotation_translation(rotation, joint.translation) @ wrist.inverse()


Finger = tuple[tuple[int, int, int], tuple[int, int, int], tuple[float, ...], float]


def _finger(palm: Pose, finger: Finger, curl: float, skin: Rgb) -> list[Body]:
    (x, y, z), lengths, radii, outward_deg = finger
    turn = Pose.exp([0, 0, math.radians(outward_deg * (1 - curl)), 0, 0, 0])
    pose = palm @ Pose.from_translation(x * 0.001, y * 0.001, z * 0.001) @ turn
    bodies = []
    for i, length in enumerate(lengths):
        pose = pose @ Pose.exp([0, math.radians(_FLEXION_DEG[i] * curl), 0, 0, 0, 0])
        # Blood shows at the tips.
        color = _redder(skin, 0.05 * i)
        bodies.append(Body(_bone(length, radii[i], radii[i + 1]), pose, color, 0.10))
        if i == len(lengths) - 1:
            bodies.append(Body(_nail(length, radii[-1]), pose, _redder(skin, 0.22), 0.45))
        pose = pose @ Pose.from_translation(length * 0.001, 0, 0)
    return bodies


def _thumb(palm: Pose, curl: float, skin: Rgb) -> list[Body]:
    pose = palm @ Pose.from_translation(-0.002, 0.040, -0.012)
    pose = pose @ Pose.exp([0, 0, math.radians(38 - 22 * curl), 0, 0, 0])
    pose = pose @ Pose.exp([math.radians(-55), 0, 0, 0, 0, 0])
    bodies = []
    for length, near, far, flexion_deg in ((34.0, 12.5, 10.5, 22.0), (29.0, 10.5, 7.8, 40.0)):
        pose = pose @ Pose.exp([0, math.radians(12 + flexion_deg * curl), 0, 0, 0, 0])
        bodies.append(Body(_bone(length, near, far), pose, _redder(skin, 0.05), 0.10))
        if far < 8:
            bodies.append(Body(_nail(length, far), pose, _redder(skin, 0.22), 0.45))
        pose = pose @ Pose.from_translation(length * 0.001, 0, 0)
    return bodies


def _redder(color: Rgb, share: float) -> Rgb:
    red, green, blue = color
    return (
        min(round(red * (1 + 0.3 * share)), 255),
        round(green * (1 - 0.6 * share)),
        round(blue * (1 - 0.5 * share)),
    )


@cache
def _bone(length: float, near: float, far: float) -> Mesh:
    return _hull([((0, 0, 0), near), ((length, 0, 0), far)])


@cache
def _nail(length: float, radius: float) -> Mesh:
    points = _sphere(_COARSE) * (0.62 * radius, 0.66 * radius, 0.3 * radius)
    return _mesh(points + np.array([length - 1.0, 0, 0.78 * radius]))


@cache
def _palm() -> Mesh:
    knuckles = [((x, y, z), 11.5) for (x, y, z), *_ in _FINGERS]
    return _hull([*knuckles, ((_WRIST_X + 6, 17, 0), 16), ((_WRIST_X + 6, -15, 0), 16)])


@cache
def _heel() -> Mesh:
    return _hull([((-36, 18, -9), 17), ((0, 40, -12), 13), ((-34, -14, -8), 15)])


@cache
def _forearm() -> Mesh:
    wrist = [((_WRIST_X, y, 0), 19.0) for y in (-11, 11)]
    return _hull([*wrist, *[((_SLEEVE_X - 40, y, 0), 27.0) for y in (-15, 15)]])


@cache
def _sleeve() -> Mesh:
    cuff = [((_SLEEVE_X, y, 0), 33.0) for y in (-17, 17)]
    return _hull([*cuff, *[((_ELBOW_X, y, 0), 44.0) for y in (-18, 18)]])


@cache
def _sphere(n: int) -> Array:
    """(n, 3) points spread evenly over the unit sphere."""
    index = np.arange(n) + 0.5
    z = 1 - 2 * index / n
    angle = math.pi * (1 + 5**0.5) * index
    radius = np.sqrt(1 - z * z)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])


def _hull(balls: Sequence[tuple[tuple[float, float, float], float]]) -> Mesh:
    """What a skin stretched over balls (centre, radius; mm) encloses."""
    n = _COARSE if max(radius for _, radius in balls) < _FINE_MM else _FINE
    return _mesh(np.vstack([_sphere(n) * radius + center for center, radius in balls]))


def _mesh(points_mm: Array) -> Mesh:
    hull = ConvexHull(points_mm)
    faces = hull.simplices.copy()
    corners = points_mm[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", normals, hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    used, index = np.unique(faces, return_inverse=True)
    vertices = (points_mm[used] * 0.001).astype(np.float32)
    return Mesh(vertices, index.reshape(-1, 3).astype(np.int32))
