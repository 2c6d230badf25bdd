"""Where the parts of an asset lie before the assembly: apart, in view, clear of what else is there.

World frame as in `script`: the bench's top is z = 0.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import islice

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Asset
from snapfit.models.errors import WorkbenchError
from snapfit.models.manifest import Link, Step
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.mounting import Mount, joined
from snapfit.models.workbench.scene import Scene
from snapfit.models.workbench.script import Place, resting_pose

_CELL_M = 0.004
_HALF_M = 0.6
_AREA_X_M, _AREA_Y_M = (-0.36, 0.36), (-0.17, 0.26)
_GAP_M, _NARROW_GAP_M = 0.012, 0.003
_TRIES, _ENOUGH = 600, 12
# Where the part that carries the others lies: the first place and turn from which all is in view.
_WORK_X_M, _WORK_YS_M, _WORK_YAWS_DEG = 0.015, (0.03, -0.03, -0.08), (24, -156, 84, -96, 144, -36)
_SIDES = tuple((s * (i == 0), s * (i == 1), s * (i == 2)) for i in range(3) for s in (-1.0, 1.0))
# The depth camera looks into a narrower angle than the colour camera; corners are cut.
_HALF_ANGLE_X_DEG, _CORNER_CUT, _BORDER_PX = 36.5, 0.45, 20

Bytes = npt.NDArray[np.uint8]


class Layout:
    """The bench's top as a grid of places that are taken or free."""

    def __init__(self, scene: Scene) -> None:
        n = round(2 * _HALF_M / _CELL_M)
        self._scene = scene
        self._taken = np.zeros((n, n), dtype=np.uint8)
        for item in scene.items:
            self._draw(self._taken, item.world_from_body.transform(item.mesh.vertices), _GAP_M)

    def reserve(self, points: Array, gap_m: float = _GAP_M) -> None:
        """Keeps the ground under points (N, 3), world frame, m, free of parts."""
        self._draw(self._taken, points, gap_m)

    def put(self, mesh: Mesh, down: tuple[float, float, float], rng: np.random.Generator) -> Pose:
        """`world_from_part` of a part that lies in view, near the middle, where nothing else is.

        Raises:
            WorkbenchError: there is no room left.
        """
        lying = resting_pose(mesh, Place(0.0, 0.0, 0.0, down))
        for gap_m in (_GAP_M, _NARROW_GAP_M):
            # All are drawn, so that what is drawn next does not follow from where there is room.
            tried = [_drawn(rng) for _ in range(_TRIES)]
            free = (
                pose
                for pose in (_standing(*each) @ lying for each in tried)
                if self._is_free(pose.transform(mesh.vertices), gap_m)
            )
            found = list(islice(free, _ENOUGH))
            if found:
                # A little from the middle, so that not all crowd there.
                pose = min(found, key=lambda pose: float(np.hypot(*pose.translation[:2])))
                self.reserve(pose.transform(mesh.vertices), gap_m)
                return pose
        raise WorkbenchError("the parts do not fit on the workbench: there is no room left in view")

    def _is_free(self, points: Array, gap_m: float) -> bool:
        own = np.zeros_like(self._taken)
        self._draw(own, points, gap_m)
        if (own & self._taken).any():
            return False
        camera = self._scene.camera
        pixels = camera.project(self._scene.camera_from_world.transform(points))
        across = np.abs(pixels[:, 0] - camera.cx) + _CORNER_CUT * np.abs(pixels[:, 1] - camera.cy)
        rows = pixels[:, 1]
        half_px = camera.fx * math.tan(math.radians(_HALF_ANGLE_X_DEG))
        inside = (rows > _BORDER_PX) & (rows < camera.height - _BORDER_PX) & (across < half_px)
        return bool(inside.all())

    def _draw(self, grid: Bytes, points: Array, gap_m: float) -> None:
        cells = np.clip((points[:, :2] + _HALF_M) / _CELL_M, -5, len(grid) + 5)
        hull = cv2.convexHull(np.round(cells).astype(np.int32))
        cv2.fillConvexPoly(grid, hull, 1)
        thickness = 2 * round(gap_m / _CELL_M) + 1
        cv2.polylines(grid, [hull], isClosed=True, color=1, thickness=thickness)


def _drawn(rng: np.random.Generator) -> tuple[float, float, float]:
    """Yaw, rad, and x, y, m, of a place anywhere in view."""
    return rng.uniform(0, 2 * math.pi), rng.uniform(*_AREA_X_M), rng.uniform(*_AREA_Y_M)


def _standing(yaw: float, x: float, y: float) -> Pose:
    return Pose.from_translation(x, y, 0) @ Pose.exp([0, 0, yaw, 0, 0, 0])


Plan = Sequence[tuple[Step, tuple[Mount, ...]]]


def laid_out(asset: Asset, scene: Scene, plan: Plan, rng: np.random.Generator) -> dict[str, Pose]:
    """`world_from_part` at first: the part that carries most in the middle, the others around.

    Raises:
        WorkbenchError: there is no room for all.
    """
    meshes = {part.name: part.mesh for part in asset.parts}
    beyond = _points_to_come(meshes, plan)
    root = root_of([mount.link for _, mounts in plan for mount in mounts])
    poses = {root: _working_pose(scene, meshes[root], beyond[root])}
    layout = Layout(scene)
    layout.reserve(poses[root].transform(meshes[root].vertices))
    others = sorted((n for n in meshes if n != root), key=lambda n: -meshes[n].diameter_m)
    for name in others:
        is_parent = len(beyond[name]) > len(meshes[name].vertices)
        side = roomiest_side(meshes[name], beyond[name]) if is_parent else None
        poses[name] = layout.put(meshes[name], side or flattest_side(meshes[name]), rng)
    return {name: poses[name] for name in meshes}


def root_of(links: Sequence[Link]) -> str:
    """The part that carries others and is carried by none; of several, that of most links."""
    children = {link.child for link in links}
    roots = [link.parent for link in links if link.parent not in children]
    return max(roots, key=roots.count)


def _points_to_come(meshes: Mapping[str, Mesh], plan: Plan) -> dict[str, Array]:
    """(N, 3) by part, its frame: itself, what is mounted on it, from where; for the root, all."""
    points = {name: [mesh.vertices.astype(np.float64)] for name, mesh in meshes.items()}
    mounts = [mount for _, mounts in plan for mount in mounts]
    links = [mount.link for mount in mounts]
    root = root_of(links)
    whole = joined(root, links)
    for mount in mounts:
        link = mount.link
        own = link.parent_from_child.transform(meshes[link.child].vertices)
        coming = own + mount.slide_m + mount.back_m
        points[link.parent] += [own, coming]
        if link.parent in whole and link.parent != root:
            points[root] += [whole[link.parent].transform(each) for each in (own, coming)]
    return {name: np.vstack(each) for name, each in points.items()}


def _working_pose(scene: Scene, mesh: Mesh, beyond: Array) -> Pose:
    """`world_from_part` where the part and all that comes to it are in view as well as can be."""
    down = roomiest_side(mesh, beyond)
    best, least_px = Pose.identity(), math.inf
    for y_m in _WORK_YS_M:
        for yaw_deg in _WORK_YAWS_DEG:
            pose = resting_pose(mesh, Place(0.0, 0.0, float(yaw_deg), down))
            points = pose.transform(mesh.vertices)
            middle = (points.min(axis=0) + points.max(axis=0)) / 2
            pose = Pose.from_translation(_WORK_X_M - middle[0], y_m - middle[1], 0) @ pose
            outside_px = _outside_px(scene, pose.transform(beyond))
            if outside_px < least_px - 0.5:
                best, least_px = pose, outside_px
    return best


def _outside_px(scene: Scene, points: Array) -> float:
    """How far the farthest of points (N, 3), world frame, is outside of the picture."""
    camera = scene.camera
    pixels = camera.project(scene.camera_from_world.transform(points))
    high = np.array([camera.width, camera.height]) - _BORDER_PX
    return float(np.maximum(np.maximum(_BORDER_PX - pixels, pixels - high), 0).max())


def flattest_side(mesh: Mesh) -> tuple[float, float, float]:
    """The direction of the body that points down when it lies as flat as it can."""
    return min(_SIDES, key=lambda down: _height_m(mesh, down))


def roomiest_side(mesh: Mesh, beyond: Array) -> tuple[float, float, float]:
    """The direction that points down when a part lies so that others can be mounted on it.

    Args:
        mesh: of the part.
        beyond: (N, 3) points where other parts will be or come along, part's frame.
    """

    def cost(down: tuple[float, float, float]) -> float:
        pose = resting_pose(mesh, Place(0.0, 0.0, 0.0, down))
        below = max(-float(pose.transform(beyond)[:, 2].min()), 0.0)
        return 3 * below + float(np.ptp(pose.transform(mesh.vertices)[:, 2]))

    return min(_SIDES, key=cost)


def _height_m(mesh: Mesh, down: tuple[float, float, float]) -> float:
    pose = resting_pose(mesh, Place(0.0, 0.0, 0.0, down))
    return float(np.ptp(pose.transform(mesh.vertices)[:, 2]))
