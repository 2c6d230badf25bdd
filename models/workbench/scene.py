"""The bench as a camera finds it: where the camera and the lamps are, what covers the ground."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import AZURE_KINECT_720P, PinholeCamera
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench import texture
from snapfit.models.workbench.clutter import Item, clutter

Singles = npt.NDArray[np.float32]

STANDARD_CAMERA = AZURE_KINECT_720P
TEXELS_PER_M = 1250
TOP_X_M, TOP_Y_M = (-0.86, 1.02), (-0.6, 0.74)
FLOOR_Z_M = -0.74
_PAPER_M = (0.297, 0.21)


@dataclass(frozen=True)
class Lamp:
    """A round lamp.

    Attributes:
        position_m: world frame.
        diameter_m: the larger, the softer its shadows.
        intensity: linear light of three channels, blue first, on a white surface 1 m away.
    """

    position_m: tuple[float, float, float]
    diameter_m: float
    intensity: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Scene:
    """All that stays as it is.

    Attributes:
        camera: of colour and depth alike.
        camera_from_world: where it stands.
        lamps: what throws shadows.
        ambient: (2, 3) light from above and from below, linear, blue first.
        items: things on the bench.
        ground: (H, W, 3) uint8 sRGB, blue first: the bench's top, rows along y, columns along x.
    """

    camera: PinholeCamera
    camera_from_world: Pose
    lamps: tuple[Lamp, ...]
    ambient: Array
    items: tuple[Item, ...]
    ground: npt.NDArray[np.uint8]

    @property
    def up(self) -> Array:
        """(3,) unit vector away from the bench, camera frame."""
        return self.camera_from_world.rotation[:, 2]

    def scaled(self, factor: float) -> Scene:
        """The same scene in a smaller or larger picture."""
        return replace(self, camera=self.camera.scaled(factor))


def standard_scene(rng: np.random.Generator) -> Scene:
    """A wooden bench under a lamp on the left and a bright ceiling."""
    return Scene(
        camera=STANDARD_CAMERA,
        camera_from_world=looking_at((0.0, -0.365, 0.43), (0.005, 0.01, 0.01)),
        lamps=(
            Lamp((-0.60, 0.05, 1.15), 0.16, (0.98, 1.10, 1.18)),
            Lamp((0.35, 0.45, 1.55), 0.75, (0.78, 0.76, 0.72)),
        ),
        ambient=np.array([[0.25, 0.24, 0.225], [0.08, 0.10, 0.115]]),
        items=clutter(),
        ground=_ground(rng),
    )


def looking_at(eye_m: tuple[float, float, float], target_m: tuple[float, float, float]) -> Pose:
    """`camera_from_world` of a camera at `eye_m` that looks at `target_m`, upright."""
    eye = np.array(eye_m)
    forward = np.array(target_m) - eye
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, (0, 0, 1) if abs(forward[2]) < 0.999 else (0, 1, 0))
    right = right / np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    return Pose.from_rotation_translation(rotation, -rotation @ eye)


def ground_seen(scene: Scene, camera: PinholeCamera) -> tuple[Singles, Singles]:
    """Depth (H, W), m, and linear albedo (H, W, 3) of bench top and floor, with nothing on them."""
    columns, rows = np.meshgrid(
        np.arange(camera.width, dtype=np.float32), np.arange(camera.height, dtype=np.float32)
    )
    rays = np.stack(
        [(columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy, np.ones_like(rows)], -1
    )
    world_from_camera = scene.camera_from_world.inverse()
    world = rays @ world_from_camera.rotation.T.astype(np.float32)
    eye = world_from_camera.translation.astype(np.float32)
    depth = (-eye[2] / np.minimum(world[..., 2], -1e-3)).astype(np.float32)
    x, y = eye[0] + depth * world[..., 0], eye[1] + depth * world[..., 1]
    on_top = (x > TOP_X_M[0]) & (x < TOP_X_M[1]) & (y > TOP_Y_M[0]) & (y < TOP_Y_M[1])
    color = cv2.remap(
        scene.ground,
        (x - TOP_X_M[0]) * TEXELS_PER_M,
        (TOP_Y_M[1] - y) * TEXELS_PER_M,
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    floor = depth * (eye[2] - FLOOR_Z_M) / eye[2]
    floor_color = np.array([138, 142, 146], dtype=np.uint8)
    depth = np.where(on_top, depth, floor)
    return depth, linear(np.where(on_top[..., None], color, floor_color))


def linear(srgb: npt.NDArray[np.uint8]) -> Singles:
    """Linear light of sRGB bytes 0 to 1 (IEC 61966-2-1)."""
    value = np.arange(256) / 255
    table = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    light: Singles = table.astype(np.float32)[srgb]
    return light


def top_shape() -> tuple[int, int]:
    """Rows and columns of the bench's top."""
    return (
        round((TOP_Y_M[1] - TOP_Y_M[0]) * TEXELS_PER_M),
        round((TOP_X_M[1] - TOP_X_M[0]) * TEXELS_PER_M),
    )


def laid_on(
    top: npt.NDArray[np.uint8],
    sheet: npt.NDArray[np.uint8],
    place_m: tuple[float, float],
    turn_deg: float,
) -> None:
    """Lays a sheet (h, w, 3) flat on the bench's top (H, W, 3), in place, its centre at a place."""
    size = sheet.shape
    turn = cv2.getRotationMatrix2D((size[1] / 2, size[0] / 2), turn_deg, 1.0)
    turn[:, 2] += (
        (place_m[0] - TOP_X_M[0]) * TEXELS_PER_M - size[1] / 2,
        (TOP_Y_M[1] - place_m[1]) * TEXELS_PER_M - size[0] / 2,
    )
    cv2.warpAffine(
        sheet,
        turn,
        (top.shape[1], top.shape[0]),
        dst=top,
        flags=cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_TRANSPARENT,
    )


def _ground(rng: np.random.Generator) -> npt.NDArray[np.uint8]:
    top = texture.wood(rng, top_shape(), TEXELS_PER_M)
    size = (round(_PAPER_M[1] * TEXELS_PER_M), round(_PAPER_M[0] * TEXELS_PER_M))
    laid_on(top, texture.paper(rng, size), (-0.20, 0.17), 17.0)
    return top
