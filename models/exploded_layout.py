"""Where the parts of an asset go in its exploded view: apart, along the ways they are mounted."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from snapfit.models.asset import Asset
from snapfit.models.manifest import Link
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.layout import flattest_side, roomiest_side
from snapfit.models.workbench.mounting import assembly_path, joined, mount
from snapfit.models.workbench.script import Place, resting_pose

# The gap between a part and the next, as a share of the asset's size, and its bounds.
_GAP_SHARE, _GAP_M = 0.09, (0.004, 0.030)
_LEAST_WAY_GAPS = 2.0


@dataclass(frozen=True, eq=False)
class ExplodedLayout:
    """Parts apart from each other.

    Attributes:
        world_from_part: by name, in the order of the asset; the bench's top is z = 0.
        ways: for each link (2, 3) from where a point of the child belongs to where it is, m.
    """

    world_from_part: Mapping[str, Pose]
    ways: tuple[Array, ...]


@dataclass(eq=False)
class _Module:
    """Parts that are linked: `module_from_part`, and the ways between them."""

    poses: dict[str, Pose]
    ways: list[Array]

    def moved(self, pose: Pose) -> _Module:
        return _Module(
            {name: pose @ each for name, each in self.poses.items()},
            [pose.transform(way) for way in self.ways],
        )


def final_links(asset: Asset) -> tuple[Link, ...]:
    """Links of the state at the end of the assembly; without steps, of that with most links."""
    if asset.steps:
        last = assembly_path(asset)[-1].to_state
        return next(state.links for state in asset.states if state.name == last)
    return max((state.links for state in asset.states), key=len, default=())


def exploded(asset: Asset) -> ExplodedLayout:
    """Moves the parts of the assembled asset apart, as they are mounted, one after the other.

    A part, with what is mounted on it already, goes back along its mounting direction until it is
    clear of all that is in its way. What is not linked stands beside.
    """
    meshes = {part.name: part.mesh for part in asset.parts}
    modules = {name: _Module({name: Pose.identity()}, []) for name in meshes}
    done: list[Link] = []
    gap_m = _gap_m(meshes, final_links(asset))
    for link in final_links(asset):
        module = _mounted(link, meshes, done, (modules[link.parent], modules[link.child]), gap_m)
        modules.update(dict.fromkeys(module.poses, module))
        done.append(link)
    children = {link.child for link in done}
    standing = [_standing(name, meshes, modules[name]) for name in meshes if name not in children]
    row = _in_a_row(meshes, standing, gap_m)
    poses = {name: pose for module in row for name, pose in module.poses.items()}
    ways = tuple(way for module in row for way in module.ways)
    return ExplodedLayout({name: poses[name] for name in meshes}, ways)


def _mounted(
    link: Link,
    meshes: Mapping[str, Mesh],
    done: Sequence[Link],
    modules: tuple[_Module, _Module],
    gap_m: float,
) -> _Module:
    """The modules of a link's parent and child as one."""
    carriers = joined(link.parent, done)
    brought = {n: link.parent_from_child @ pose for n, pose in joined(link.child, done).items()}
    direction = mount(link, meshes, carriers, brought).direction
    parent, child = modules
    place = parent.poses[link.parent]
    direction = place.rotation @ direction
    home = child.moved(place @ link.parent_from_child @ child.poses[link.child].inverse())
    way_m = _clear_m(meshes, parent.poses, home.poses, direction, gap_m)
    away = home.moved(Pose.from_translation(*(way_m * direction)))
    point = _way_point(link, meshes[link.child], home.poses[link.child].rotation.T @ direction)
    way = np.vstack([each.poses[link.child].transform(point[None]) for each in (home, away)])
    return _Module(parent.poses | away.poses, [*parent.ways, *away.ways, way])


def _clear_m(
    meshes: Mapping[str, Mesh],
    standing: Mapping[str, Pose],
    moving: Mapping[str, Pose],
    direction: Array,
    gap_m: float,
) -> float:
    """How far parts go along a direction (3,), unit, to be past those that are in their way."""
    across = np.linalg.svd(direction[None])[2][1:]
    way_m = _LEAST_WAY_GAPS * gap_m
    for own, other in itertools.product(moving, standing):
        points = moving[own].transform(meshes[own].vertices)
        obstacle = standing[other].transform(meshes[other].vertices)
        if _overlap(points @ across.T, obstacle @ across.T):
            past_m = float((obstacle @ direction).max() - (points @ direction).min())
            way_m = max(way_m, past_m + gap_m)
    return way_m


def _overlap(a: Array, b: Array) -> bool:
    """Whether the hulls of two sets of points (N, 2), m, have a square millimetre in common."""
    hulls = [cv2.convexHull((each * 1000).astype(np.float32)) for each in (a, b)]
    return bool(cv2.intersectConvexConvex(*hulls)[0] > 1)


def _standing(root: str, meshes: Mapping[str, Mesh], module: _Module) -> _Module:
    """A module on the bench, turned so that its root has room below."""
    module = module.moved(module.poses[root].inverse())
    beyond = np.vstack(
        [pose.transform(meshes[name].vertices) for name, pose in module.poses.items()]
    )
    if len(module.poses) > 1:
        down = roomiest_side(meshes[root], beyond)
    else:
        down = flattest_side(meshes[root])
    return module.moved(resting_pose(meshes[root], Place(0.0, 0.0, 0.0, down)))


def _in_a_row(
    meshes: Mapping[str, Mesh], modules: Sequence[_Module], gap_m: float
) -> list[_Module]:
    row, right_m = [], 0.0
    for module in modules:
        points = _points(meshes, module)
        low, high = points.min(axis=0), points.max(axis=0)
        x_m = right_m - low[0]
        row.append(module.moved(Pose.from_translation(x_m, -(low[1] + high[1]) / 2, 0)))
        right_m += high[0] - low[0] + _LEAST_WAY_GAPS * gap_m
    return row


def _points(meshes: Mapping[str, Mesh], module: _Module) -> Array:
    """(N, 3) vertices of a module, m."""
    return np.vstack([pose.transform(meshes[name].vertices) for name, pose in module.poses.items()])


def _gap_m(meshes: Mapping[str, Mesh], links: Sequence[Link]) -> float:
    """A share of the largest module's size."""
    sizes = []
    for name in meshes:
        whole = joined(name, links)
        points = np.vstack([pose.transform(meshes[n].vertices) for n, pose in whole.items()])
        sizes.append(float(np.linalg.norm(np.ptp(points, axis=0))))
    return float(np.clip(_GAP_SHARE * max(sizes), *_GAP_M))


def _way_point(link: Link, mesh: Mesh, direction: Array) -> Array:
    """(3,) the child's point whose way is drawn, its frame.

    It is on the axis about which the child turns; else in the middle of its box or, where that is
    empty, beside it.

    Args:
        link: with the joint.
        mesh: of the child.
        direction: (3,) unit, child's frame, in which it goes.
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    middle: Array = (low.astype(np.float64) + high) / 2
    joint = link.joint
    if joint.axis is not None and joint.type.turns:
        axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
        point = np.array(joint.point_m)
        on_axis: Array = point + ((middle - point) @ axis) * axis
        return on_axis
    if _is_inside(mesh, middle):
        return middle
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    points = np.vstack([corners.mean(axis=1), *(corners[:, i] for i in range(3))])
    aside: Array = points[np.linalg.norm(points - middle, axis=1).argmin()] - middle
    return middle + aside - (aside @ direction) * direction


def _is_inside(mesh: Mesh, point: Array) -> bool:
    """Whether a mesh goes around a point: the sum of the solid angles of its faces.

    Source: Van Oosterom and Strackee, The Solid Angle of a Plane Triangle, 1983, equation 8.
    """
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(np.float64) - point, 1, 0)
    la, lb, lc = (np.linalg.norm(each, axis=1) for each in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    dots = [np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a))]
    angles = 2 * np.arctan2(volume, la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb)
    return bool(abs(angles.sum()) > 2 * np.pi)
