"""How one part comes to another: from which side, how far along a line, with which turns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from snapfit.models.asset import Asset
from snapfit.models.camera import PinholeCamera
from snapfit.models.errors import WorkbenchError
from snapfit.models.manifest import JointType, Link, Step
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.rasteriser import render
from snapfit.models.workbench.scene import looking_at

_FAR_M, _VIEW_PX = 4.0, 128
_CLEARANCE_M = 0.012
_REACH_M = (0.03, 0.14)
_SLIDE_M = 0.05


@dataclass(frozen=True, eq=False)
class Mount:
    """A link that comes into being.

    Attributes:
        link: parent, child and joint.
        direction: (3,) unit, parent's frame: from which side the child comes.
        reach_m: how far away the straight last stretch begins.
        slide_m: (3,) parent's frame, from the place back to where the child is set down before it
            slides along its joint; zero where it does not.
    """

    link: Link
    direction: Array
    reach_m: float
    slide_m: Array

    @property
    def back_m(self) -> Array:
        """(3,) way back along the straight last stretch, parent's frame."""
        return self.reach_m * self.direction


def assembly_path(asset: Asset) -> tuple[Step, ...]:
    """The longest way through the assembly graph; of equals, that which stands first.

    Raises:
        WorkbenchError: there is no step.
    """

    def longest(state: str) -> tuple[Step, ...]:
        ways = [(step, *longest(step.to_state)) for step in asset.steps if step.from_state == state]
        return max(ways, key=len, default=())

    path = longest(asset.states[0].name) if asset.states else ()
    if not path:
        raise WorkbenchError(
            f"the workbench assembles assets with steps; {asset.name!r} has no step that leads "
            "away from its first state"
        )
    return path


def new_links(asset: Asset, step: Step) -> tuple[Link, ...]:
    """Links that a step makes, or whose child it moves elsewhere."""
    states = {state.name: state for state in asset.states}
    old = {
        (each.parent, each.child): each.parent_from_child for each in states[step.from_state].links
    }
    return tuple(
        link
        for link in states[step.to_state].links
        if not _same(old.get((link.parent, link.child)), link.parent_from_child)
    )


def joined(part: str, links: Sequence[Link]) -> dict[str, Pose]:
    """`part_from_other` of all that is joined to a part, itself too."""
    found = {part: Pose.identity()}
    waiting = [part]
    while waiting:
        name = waiting.pop()
        for link in links:
            if link.parent == name and link.child not in found:
                found[link.child] = found[name] @ link.parent_from_child
                waiting.append(link.child)
            elif link.child == name and link.parent not in found:
                found[link.parent] = found[name] @ link.parent_from_child.inverse()
                waiting.append(link.parent)
    return found


def plan_mounts(asset: Asset) -> tuple[tuple[Step, tuple[Mount, ...]], ...]:
    """What each step of the assembly brings together, in order.

    Raises:
        WorkbenchError: as `assembly_path`.
    """
    meshes = {part.name: part.mesh for part in asset.parts}
    links: list[Link] = []
    plan = []
    for step in assembly_path(asset):
        mounts = []
        for link in new_links(asset, step):
            links = [each for each in links if (each.parent, each.child) != _ends(link)]
            carriers, own = joined(link.parent, links), joined(link.child, links)
            brought = {name: link.parent_from_child @ pose for name, pose in own.items()}
            carriers = {name: pose for name, pose in carriers.items() if name not in brought}
            mounts.append(mount(link, meshes, carriers or {link.parent: Pose.identity()}, brought))
            links.append(link)
        plan.append((step, tuple(mounts)))
    return tuple(plan)


def mount(
    link: Link,
    meshes: Mapping[str, Mesh],
    carriers: Mapping[str, Pose],
    brought: Mapping[str, Pose],
) -> Mount:
    """Chooses the side from which a child comes: that from which it is seen best in its place.

    Args:
        link: that comes into being.
        meshes: by part.
        carriers: `parent_from_part` of the parent and all that is joined to it.
        brought: `parent_from_part` of the child and all that comes with it, in their places.
    """
    slide_m = _slide_m(link)
    shift = Pose.from_translation(*slide_m)
    brought = {name: shift @ pose for name, pose in brought.items()}
    options = _directions(link)
    shares = [_seen_share(direction, meshes, carriers, brought) for direction in options]
    # What the joint is about goes first where it is as good.
    best = max(range(len(options)), key=lambda i: (round(shares[i], 1), -i))
    direction = options[best]
    far = max(_span(meshes[name], pose, direction)[1] for name, pose in carriers.items())
    near = min(_span(meshes[name], pose, direction)[0] for name, pose in brought.items())
    return Mount(link, direction, float(np.clip(far - near + _CLEARANCE_M, *_REACH_M)), slide_m)


def _slide_m(link: Link) -> Array:
    joint = link.joint
    if joint.type is not JointType.PRISMATIC or joint.travel_m is None or joint.axis is None:
        return np.zeros(3)
    axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
    farthest = float(np.clip(max(joint.travel_m, key=abs), -_SLIDE_M, _SLIDE_M))
    away: Array = link.parent_from_child.rotation @ axis * farthest
    return away


def _directions(link: Link) -> list[Array]:
    """(3,) unit directions in the parent's frame."""
    rotation = link.parent_from_child.rotation
    if link.joint.axis is not None:
        axis = rotation @ np.array(link.joint.axis, dtype=np.float64)
        axis /= np.linalg.norm(axis)
        if link.joint.type in (JointType.SCREW, JointType.CYLINDRICAL):
            return [axis, -axis]
        others = [column for column in rotation.T if abs(column @ axis) < 0.9]
        return [axis, -axis, *others, *(-each for each in others)]
    return [sign * column for column in rotation.T[::-1] for sign in (1.0, -1.0)]


def _seen_share(
    direction: Array,
    meshes: Mapping[str, Mesh],
    carriers: Mapping[str, Pose],
    brought: Mapping[str, Pose],
) -> float:
    """Share of the brought parts' outline that is seen from far away: 1 if nothing is before."""
    points = np.vstack([pose.transform(meshes[name].vertices) for name, pose in brought.items()])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.linalg.norm(points - middle, axis=1).max())
    eye = middle + _FAR_M * direction
    view = looking_at((eye[0], eye[1], eye[2]), (middle[0], middle[1], middle[2]))
    focal = _VIEW_PX / 2 * _FAR_M / radius
    half = (_VIEW_PX - 1) / 2
    camera = PinholeCamera(_VIEW_PX, _VIEW_PX, focal, focal, half, half)
    own = [(meshes[name], view @ pose) for name, pose in brought.items()]
    others = [(meshes[name], view @ pose) for name, pose in carriers.items()]
    alone = int((render(camera, own).part_id > 0).sum())
    together = render(camera, own + others).part_id
    return float(((together > 0) & (together <= len(own))).sum() / max(alone, 1))


def _span(mesh: Mesh, pose: Pose, direction: Array) -> tuple[float, float]:
    along = pose.transform(mesh.vertices) @ direction
    return float(along.min()), float(along.max())


def _ends(link: Link) -> tuple[str, str]:
    return link.parent, link.child


def _same(a: Pose | None, b: Pose) -> bool:
    return a is not None and a.distance_to(b) < 1e-6 and a.angle_to(b) < 1e-6
