"""A picture of an asset in parts: each shaded in its colour, moved apart, named, on white."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Asset, Part
from snapfit.models.camera import PinholeCamera
from snapfit.models.exploded_labels import Box, draw_labels, place_labels
from snapfit.models.exploded_layout import ExplodedLayout, exploded
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.rasteriser import Rendering, render
from snapfit.models.workbench.scene import looking_at

Bytes = npt.NDArray[np.uint8]
Bodies = Sequence[tuple[Mesh, Pose]]

_WIDTH_PX, _HEIGHT_PX = 1400, 1000
_MARGIN_X_PX, _MARGIN_Y_PX, _FRAME_PX = 230, 90, 34
# From this many radii away lines that are parallel nearly stay so.
_FAR_RADII = 7.0
_SAMPLES = 2
_YAWS_DEG, _ELEVATIONS_DEG, _TRY_PX = range(0, 360, 15), (22, 32, 42), 220
_LIGHT = np.array([-0.45, -0.70, -0.55])
_AMBIENT, _DIFFUSE, _FACING = 0.46, 0.46, 0.14
_CREASE_COSINE, _STEP_SHARE = 0.86, 0.012
_LINE_BGR, _DASH_M = (120, 120, 120), 0.0035


@dataclass(frozen=True, eq=False)
class ExplodedView:
    """The picture, and what is where in it.

    Attributes:
        image: (H, W, 3) uint8, blue first.
        part_id: (H, W) uint8, 0 = nothing, i + 1 = the i-th part of the asset.
        labels: box (left, top, right, bottom; px) of each part's name.
    """

    image: Bytes
    part_id: Bytes
    labels: Mapping[str, Box]


def exploded_view(asset: Asset) -> ExplodedView:
    """Draws the asset of the last assembly state in parts, seen from where most of it shows."""
    layout = exploded(asset)
    eye = _best_view(asset.parts, layout)
    camera, view = _framed(asset.parts, layout, eye)
    bodies = _bodies(asset.parts, layout, view)
    fine = render(camera.scaled(_SAMPLES), bodies, normals=True)
    image = _shaded(fine, asset.parts)
    _draw_ways(image, fine.depth, camera.scaled(_SAMPLES), [view.transform(w) for w in layout.ways])
    size = (camera.width, camera.height)
    image = cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
    part_id = render(camera, bodies).part_id
    ink = (image < 250).any(axis=-1)
    names = [part.name for part in asset.parts]
    labels = place_labels(names, part_id, ink)
    draw_labels(image, labels)
    return _cropped(ExplodedView(image, part_id, {label.name: label.box for label in labels}))


def _bodies(parts: Sequence[Part], layout: ExplodedLayout, view: Pose) -> Bodies:
    return [(part.mesh, view @ layout.world_from_part[part.name]) for part in parts]


def _points(parts: Sequence[Part], layout: ExplodedLayout) -> Array:
    """(N, 3) all vertices, world frame, m."""
    return np.vstack(
        [layout.world_from_part[part.name].transform(part.mesh.vertices) for part in parts]
    )


def _view(points: Array, yaw_deg: float, elevation_deg: float) -> tuple[Pose, float]:
    """`camera_from_world` of a camera that looks at points from far away; their radius, m."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius_m = float(np.linalg.norm(points - middle, axis=1).max())
    yaw, elevation = math.radians(yaw_deg), math.radians(elevation_deg)
    away = np.array(
        [
            math.cos(elevation) * math.sin(yaw),
            -math.cos(elevation) * math.cos(yaw),
            math.sin(elevation),
        ]
    )
    x, y, z = middle + _FAR_RADII * radius_m * away
    return looking_at((x, y, z), (middle[0], middle[1], middle[2])), radius_m


def _best_view(parts: Sequence[Part], layout: ExplodedLayout) -> Pose:
    """`camera_from_world` from where the parts hide each other least and appear large."""
    points = _points(parts, layout)
    focal, half = 0.48 * _TRY_PX * _FAR_RADII, (_TRY_PX - 1) / 2
    camera = PinholeCamera(_TRY_PX, _TRY_PX, focal, focal, half, half)
    best, best_score = Pose.identity(), -math.inf
    for elevation_deg in _ELEVATIONS_DEG:
        for yaw_deg in _YAWS_DEG:
            view, _ = _view(points, yaw_deg, elevation_deg)
            bodies = _bodies(parts, layout, view)
            together = np.bincount(render(camera, bodies).part_id.ravel(), minlength=len(parts) + 1)
            alone = np.array([np.count_nonzero(render(camera, [body]).depth) for body in bodies])
            seen = together[1:] / np.maximum(alone, 1)
            size = alone.sum() / _TRY_PX**2
            score = 2 * float(seen.min()) + float(seen.mean()) + 1.5 * float(size)
            if score > best_score + 1e-9:
                best, best_score = view, score
    return best


def _framed(
    parts: Sequence[Part], layout: ExplodedLayout, view: Pose
) -> tuple[PinholeCamera, Pose]:
    """A camera in whose picture all is as large as can be, with room for names around."""
    inside = view.transform(_points(parts, layout))
    flat = inside[:, :2] / inside[:, 2:]
    low, high = flat.min(axis=0), flat.max(axis=0)
    room = np.array([_WIDTH_PX - 2 * _MARGIN_X_PX, _HEIGHT_PX - 2 * _MARGIN_Y_PX])
    focal = float((room / (high - low)).min())
    width = math.ceil((high[0] - low[0]) * focal) + 2 * _MARGIN_X_PX
    height = math.ceil((high[1] - low[1]) * focal) + 2 * _MARGIN_Y_PX
    cx, cy = _MARGIN_X_PX - low[0] * focal, _MARGIN_Y_PX - low[1] * focal
    return PinholeCamera(width, height, focal, focal, float(cx), float(cy)), view


def _shaded(seen: Rendering, parts: Sequence[Part]) -> Bytes:
    """(H, W, 3) matt surfaces under a light from the upper left, with darkened edges."""
    image = np.full((*seen.depth.shape, 3), 255.0)
    inside = seen.part_id > 0
    if seen.normal is None or not inside.any():
        return image.astype(np.uint8)
    normal = seen.normal[inside].astype(np.float64)
    light = _LIGHT / np.linalg.norm(_LIGHT)
    strength = _AMBIENT + _DIFFUSE * np.maximum(normal @ light, 0) - _FACING * normal[:, 2]
    colors = np.array([part.color_rgb[::-1] for part in parts], dtype=np.float64)
    # Dark plastic is lifted a little, or its shape would not show.
    colors = 30 + colors * (225 / 255)
    image[inside] = colors[seen.part_id[inside].astype(np.intp) - 1] * strength[:, None]
    image[_edges(seen)] *= 0.55
    return np.clip(image, 0, 255).astype(np.uint8)


def _edges(seen: Rendering) -> npt.NDArray[np.bool_]:
    """(H, W) where a part ends, folds, or stands before itself."""
    edge = np.zeros(seen.depth.shape, dtype=bool)
    inside = seen.part_id > 0
    for axis in (0, 1):
        first = (slice(None, -1), slice(None)) if axis == 0 else (slice(None), slice(None, -1))
        second = (slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))
        nearer, farther = seen.depth[first], seen.depth[second]
        step = np.abs(nearer - farther) > _STEP_SHARE * np.minimum(nearer, farther)
        change = (seen.part_id[first] != seen.part_id[second]) | step
        if seen.normal is not None:
            cosine = np.einsum("ijk,ijk->ij", seen.normal[first], seen.normal[second])
            change |= cosine < _CREASE_COSINE
        edge[first] |= change
        edge[second] |= change
    return edge & inside


def _draw_ways(
    image: Bytes, depth: npt.NDArray[np.float32], camera: PinholeCamera, ways: Sequence[Array]
) -> None:
    """Dashed lines (2, 3), camera frame, m, in place, hidden by what is before them."""
    for start, end in ways:
        n_dashes = max(round(float(np.linalg.norm(end - start)) / _DASH_M), 1) | 1
        for i in range(0, n_dashes, 2):
            ends = [start + (end - start) * (k / n_dashes) for k in (i, i + 1)]
            middle = (ends[0] + ends[1]) / 2
            column, row = np.rint(camera.project(middle)).astype(int)
            if 0 < depth[row, column] < middle[2]:
                continue
            a, b = (np.rint(camera.project(each)).astype(int) for each in ends)
            cv2.line(image, (a[0], a[1]), (b[0], b[1]), _LINE_BGR, _SAMPLES + 1, cv2.LINE_AA)


def _cropped(view: ExplodedView) -> ExplodedView:
    """Without the white that is left around, but for a frame."""
    ink: npt.NDArray[np.bool_] = (view.image < 250).max(axis=-1)
    rows, columns = np.flatnonzero(ink.any(axis=1)), np.flatnonzero(ink.any(axis=0))
    top, left = max(rows[0] - _FRAME_PX, 0), max(columns[0] - _FRAME_PX, 0)
    window = slice(top, rows[-1] + _FRAME_PX), slice(left, columns[-1] + _FRAME_PX)
    labels = {
        name: (int(box[0] - left), int(box[1] - top), int(box[2] - left), int(box[3] - top))
        for name, box in view.labels.items()
    }
    return ExplodedView(view.image[window].copy(), view.part_id[window].copy(), labels)
