"""Draws the tracked parts into the camera's image: tint, outline, axes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Part
from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.tracking.result import PartEstimate, Status

Image = npt.NDArray[np.uint8]

_TINT = 0.4
_AXIS_SHARE = 0.4
_AXES_BGR = ((60, 60, 230), (60, 200, 60), (230, 120, 40))
_UNSURE_BGR = (0, 200, 255)


def draw_overlay(
    image: Image, camera: PinholeCamera, parts: Sequence[Part], estimates: Iterable[PartEstimate]
) -> Image:
    """The image with every part that has a pose drawn over it in its own colour.

    Parts that are seen have a white outline; those whose pose is carried on without being seen
    (`inferred`, `predicted`) an amber one.

    Args:
        image: (H, W, 3) uint8, BGR; not changed.
        camera: the colour camera.
        parts: meshes and colours.
        estimates: poses, for any of the parts.

    Returns:
        (H, W, 3) uint8, BGR.
    """
    by_name = {part.name: part for part in parts}
    drawn = [
        (by_name[estimate.part], estimate.camera_from_body, estimate.status)
        for estimate in estimates
        if estimate.camera_from_body is not None and estimate.part in by_name
    ]
    overlay = image.copy()
    if not drawn:
        return overlay
    rendering = render(camera, [(part.mesh, pose) for part, pose, _ in drawn], normals=True)
    if rendering.normal is not None:
        _tint(overlay, rendering.part_id, rendering.normal, [part for part, _, _ in drawn])
    _outline(overlay, rendering.part_id, [status for _, _, status in drawn])
    for part, pose, _ in drawn:
        _draw_axes(overlay, camera, part, pose)
    return overlay


def _tint(
    overlay: Image,
    part_id: npt.NDArray[np.uint8],
    normal: npt.NDArray[np.float32],
    parts: Sequence[Part],
) -> None:
    """Blend each part's colour in, lit from the camera so that its shape shows."""
    colors = np.array([(0, 0, 0)] + [part.color_rgb[::-1] for part in parts], dtype=np.float32)
    rows, columns = np.nonzero(part_id)
    light = 0.35 + 0.65 * np.abs(normal[rows, columns, 2])
    tint = colors[part_id[rows, columns]] * light[:, None]
    overlay[rows, columns] = (1 - _TINT) * overlay[rows, columns] + _TINT * tint


def _outline(overlay: Image, part_id: npt.NDArray[np.uint8], statuses: Sequence[Status]) -> None:
    """Draw the border of every part against what is around it, hidden edges left out."""
    for i, status in enumerate(statuses):
        mask = (part_id == i + 1).astype(np.uint8)
        contours, _ = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        color = (255, 255, 255) if status is Status.TRACKED else _UNSURE_BGR
        cv2.drawContours(overlay, contours, -1, color, 1, cv2.LINE_AA)


def _draw_axes(overlay: Image, camera: PinholeCamera, part: Part, pose: Pose) -> None:
    """Draw the body frame's axes at its origin: x red, y green, z blue."""
    length_m = _AXIS_SHARE * part.mesh.radius_m
    points = pose.transform(np.vstack([np.zeros(3), np.eye(3) * length_m]))
    if (points[:, 2] <= 0.01).any():
        return
    pixels = np.round(camera.project(points)).astype(int).tolist()
    for end, color in zip(pixels[1:], _AXES_BGR, strict=True):
        cv2.line(overlay, tuple(pixels[0]), tuple(end), color, 2, cv2.LINE_AA)
