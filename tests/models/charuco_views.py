"""Images of a board as a camera with a lens sees them: every pixel is traced to the board."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from snapfit.models.camera import PinholeCamera
from snapfit.models.charuco import CharucoBoard
from snapfit.models.pose import Pose

CAMERA = PinholeCamera(640, 480, 545.0, 548.0, 326.0, 233.0)
DISTORTION = (-0.18, 0.06, 0.0012, -0.0008, 0.0)
BOARD = CharucoBoard()


def poses(n: int, seed: int = 0, tilt_rad: float = 0.6) -> Iterator[Pose]:
    """`camera_from_board`: before the camera, tilted, all over the image."""
    rng = np.random.default_rng(seed)
    for _ in range(n):
        z_m = rng.uniform(0.28, 0.5)
        x_m, y_m = rng.uniform(-0.3, 0.3) * z_m, rng.uniform(-0.22, 0.22) * z_m
        turn = Pose.exp([*rng.uniform(-tilt_rad, tilt_rad, 2), rng.uniform(-0.4, 0.4), 0, 0, 0])
        center = Pose.from_translation(-0.126, -0.084, 0.0)
        yield Pose.from_translation(x_m, y_m, z_m) @ turn @ center


def rendered(
    pose: Pose, seed: int = 0, board: CharucoBoard = BOARD, scale: float = 1.0
) -> np.ndarray:
    """(480, 640) uint8; `scale`: of the printed board, 1 where it is as it says."""
    y, x = np.mgrid[: CAMERA.height, : CAMERA.width].astype(np.float64)
    seen = np.stack([x.ravel(), y.ravel()], axis=1)[:, None]
    rays = cv2.undistortPoints(seen, CAMERA.matrix, np.array(DISTORTION))[:, 0]
    board_from_camera = pose.inverse()
    direction = np.column_stack([rays, np.ones(len(rays))]) @ board_from_camera.rotation.T
    distance = -board_from_camera.translation[2] / direction[:, 2]
    at_m = board_from_camera.translation[:2] + distance[:, None] * direction[:, :2]
    px_per_m = 224 / (board.square_mm / 1000) / scale
    texture = cv2.GaussianBlur(np.pad(board.image(224), 112, constant_values=255), (0, 0), 3)
    shape = (CAMERA.height, CAMERA.width)
    place = (at_m * px_per_m + 111.5).astype(np.float32)
    place[distance <= 0] = -1
    image = cv2.remap(
        texture,
        place[:, 0].reshape(shape),
        place[:, 1].reshape(shape),
        cv2.INTER_LINEAR,
        borderValue=120,
    )
    noise = np.random.default_rng(seed).normal(0, 3, shape)
    return np.clip(image + noise, 0, 255).astype(np.uint8)
