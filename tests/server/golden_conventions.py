"""Makes openapi/conventions.json: python tests/server/golden_conventions.py.

Imports nothing of snapfit. Everything follows from one matrix a convention, whose rows are read
off a drawing: where do x, y and z of that convention point, along OpenCV's axes?
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

FILE = Path(__file__).parents[2] / "openapi" / "conventions.json"

RIGHT, DOWN, FORWARD = np.eye(3)
LEFT, UP, BACKWARD = -RIGHT, -DOWN, -FORWARD

CONVENTIONS: dict[str, tuple[str, Array]] = {
    "opencv": ("x right, y down, z forward", np.array([RIGHT, DOWN, FORWARD])),
    "openxr": ("x right, y up, z backward", np.array([RIGHT, UP, BACKWARD])),
    "unity": ("x right, y up, z forward; left-handed", np.array([RIGHT, UP, FORWARD])),
    "ros": ("x forward, y left, z up", np.array([FORWARD, LEFT, UP])),
    "ros_optical": ("x right, y down, z forward", np.array([RIGHT, DOWN, FORWARD])),
}
GLTF = np.array([RIGHT, UP, BACKWARD])

# camera_from_body as rotations by axis and angle (degrees) and the body's origin in the camera.
CASES: dict[str, tuple[list[float], float, list[float]]] = {
    "not turned, a metre ahead": ([1, 0, 0], 0, [0, 0, 1]),
    "to the right and below": ([1, 0, 0], 0, [0.25, 0.125, 0.75]),
    "a quarter turn about x": ([1, 0, 0], 90, [0, 0, 0.5]),
    "a quarter turn about y": ([0, 1, 0], 90, [0, 0, 0.5]),
    "a quarter turn about z": ([0, 0, 1], 90, [0, 0, 0.5]),
    "half round": ([0, 1, 0], 180, [-0.1, 0.2, 0.6]),
    "a third of a turn about the diagonal": ([1, 1, 1], 120, [0.1, -0.2, 0.7]),
    "askew": ([2, -1, 3], 77, [-0.3, 0.15, 0.9]),
}
VERTEX = np.array([0.03, -0.02, 0.05])
LINEAR = np.array([0.1, -0.2, 0.3])
ANGULAR = np.array([1.0, 0.5, -0.25])
# Where the camera stands in an anchor's frame, for `frame=anchor:ID`: turned by 30 degrees about
# an axis that is askew.
ANCHOR = ([0, 3, 4], 30, [0.5, 1.5, -2.0])


def matrix_of(axis: list[float], degrees: float) -> Array:
    """Rodrigues' formula."""
    n = np.array(axis, dtype=float) / np.linalg.norm(axis)
    hat = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    angle = np.radians(degrees)
    result: Array = np.eye(3) + np.sin(angle) * hat + (1 - np.cos(angle)) * hat @ hat
    return result


def quaternion_of(rotation: Array) -> Array:
    """x, y, z, w: the eigenvector of a symmetric matrix that is linear in the rotation."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    k = np.array(
        [
            [a - e - i, b + d, c + g, h - f],
            [b + d, e - a - i, f + h, c - g],
            [c + g, f + h, i - a - e, d - b],
            [h - f, c - g, d - b, a + e + i],
        ]
    )
    q: Array = np.linalg.eigh(k / 3)[1][:, -1]
    first = q[3] if abs(q[3]) > 1e-9 else q[np.abs(q) > 1e-9][0]
    return q * np.sign(first)


def covariance() -> Array:
    """Some symmetric positive definite matrix: rotation first, then translation."""
    rows = np.arange(36, dtype=float).reshape(6, 6) % 7 - 3
    scale = np.diag([1e-2, 2e-2, 3e-2, 1e-3, 2e-3, 3e-3])
    result: Array = scale @ (rows @ rows.T + np.eye(6)) @ scale
    return result


def in_convention(b: Array, rotation: Array, position: Array, turn: Array) -> dict[str, Any]:
    """A pose and all that goes with it.

    Args:
        b: convention_from_opencv.
        rotation, position: frame_from_body, along OpenCV's axes.
        turn: frame_from_camera, the rotation alone, for velocities given in the camera frame.
    """
    # A mirror keeps lengths and turns the sense of rotations round.
    sense = round(float(np.linalg.det(b)))
    both = np.zeros((6, 6))
    both[:3, :3], both[3:, 3:] = sense * b, b
    mapped = b @ rotation @ b.T
    vertex = b @ VERTEX
    return {
        "position": tell(b @ position),
        "orientation": tell(quaternion_of(mapped)),
        "linear_velocity": tell(b @ turn @ LINEAR),
        "angular_velocity": tell(sense * b @ turn @ ANGULAR),
        "covariance": tell(both @ covariance() @ both.T),
        "vertex_in_body": tell(vertex),
        "vertex_in_frame": tell(mapped @ vertex + b @ position),
    }


def tell(values: Array) -> list[float]:
    return [round(float(value), 12) + 0.0 for value in np.asarray(values).ravel()]


def document() -> dict[str, Any]:
    anchor_turn, anchor_at = matrix_of(*ANCHOR[:2]), np.array(ANCHOR[2])
    cases = []
    for name, (axis, degrees, position) in CASES.items():
        rotation, at = matrix_of(axis, degrees), np.array(position, dtype=float)
        in_anchor = anchor_turn @ rotation, anchor_turn @ at + anchor_at
        cases.append(
            {
                "name": name,
                "camera": {
                    key: in_convention(b, rotation, at, np.eye(3))
                    for key, (_, b) in CONVENTIONS.items()
                },
                "anchor": {
                    key: in_convention(b, *in_anchor, anchor_turn)
                    for key, (_, b) in CONVENTIONS.items()
                },
            }
        )
    return {
        "about": "Golden vectors of snapfit's conventions; docs/conventions.md explains them. "
        "Metres, radians; quaternions x, y, z, w, of which the negative is the same; matrices by "
        "rows. For every case and convention: frame_from_body as position and orientation, its "
        "velocities, the covariance of the right perturbation in the body frame (rotation, then "
        "translation), and a mesh vertex in the body and in the frame: "
        "orientation * vertex_in_body + position = vertex_in_frame.",
        "conventions": {
            key: {
                "axes": axes,
                "convention_from_opencv": b.astype(int).tolist(),
                "convention_from_gltf": (b @ GLTF.T).astype(int).tolist(),
            }
            for key, (axes, b) in CONVENTIONS.items()
        },
        "gltf": {
            "axes": "x right, y up, z backward",
            "gltf_from_opencv": GLTF.astype(int).tolist(),
            "vertex_in_body": tell(GLTF @ VERTEX),
        },
        "anchor_from_camera": {
            key: {
                "position": tell(b @ anchor_at),
                "orientation": tell(quaternion_of(b @ anchor_turn @ b.T)),
            }
            for key, (_, b) in CONVENTIONS.items()
        },
        "cases": cases,
    }


def text() -> str:
    """The file: lists of numbers on one line each."""
    lines = json.dumps(document(), indent=1) + "\n"
    return re.sub(r"\[[^][{}\"]*\]", lambda found: " ".join(found[0].split()), lines)


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
