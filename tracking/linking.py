"""Puts the links of an assembly state into the optimiser, with the poses before the switch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from snapfit.models.asset import Part
from snapfit.models.joint import JointMotion
from snapfit.models.manifest import Joint, Link
from snapfit.models.symmetry import NO_SYMMETRY, Symmetry
from snapfit.tracking.assembly.graph import has_link
from snapfit.tracking.assembly.link_error import LinkMeasure
from snapfit.tracking.optimiser import Optimiser

_RIGID = Joint()


class Linker:
    """Keeps the optimiser's structures those of one assembly state.

    Args:
        parts: tracked parts, in the optimiser's order.
        optimiser: whose bodies are linked.
        is_rigid: joints keep the coordinates of the manifest, as in the GBOT paper.
    """

    def __init__(self, parts: Sequence[Part], optimiser: Optimiser, *, is_rigid: bool) -> None:
        self._parts = {part.name: part for part in parts}
        self._index = {part.name: i for i, part in enumerate(parts)}
        self._optimiser = optimiser
        self._is_rigid = is_rigid
        self._held: dict[str, Link] = {}

    def parent_of(self, child: str) -> str | None:
        """Name of the part that carries a part; None where it is free."""
        link = self._held.get(child)
        return None if link is None else link.parent

    def apply(self, links: Sequence[Link], is_seen: Mapping[str, bool]) -> tuple[str, ...]:
        """Make the links of a state those of the optimiser.

        Args:
            links: of the state; those between parts that are not tracked are left out.
            is_seen: by part, whether its pose can be trusted; a part that is not stands where
                the link wants it.

        Returns:
            names of the parts whose pose jumped.
        """
        wanted = {
            link.child: link
            for link in links
            if link.parent in self._parts and link.child in self._parts
        }
        for child, link in list(self._held.items()):
            if child not in wanted or not has_link([wanted[child]], link):
                self._optimiser.structures.unlink(self._index[child])
                del self._held[child]
        jumped: list[str] = []
        for child, link in wanted.items():
            if child not in self._held:
                self._join(link, is_seen)
                self._held[child] = link
                jumped += [link.parent, child]
        return tuple(jumped)

    def _join(self, link: Link, is_seen: Mapping[str, bool]) -> None:
        """Link two bodies; the module that is seen stays, the parent's if both are.

        A parent that is hidden itself stands where the rest of its module puts it.
        """
        optimiser, structures = self._optimiser, self._optimiser.structures
        child, parent = self._index[link.child], self._index[link.parent]
        joint = JointMotion.of(self._rigid(link) if self._is_rigid else link)
        q = np.clip(np.zeros(joint.n_dof), joint.limits[:, 0], joint.limits[:, 1])
        camera_from_child = optimiser.pose(child)
        parent_is_seen = self._any_seen(parent, is_seen)
        if parent_is_seen and is_seen[link.child]:
            relative = optimiser.pose(parent).inverse() @ camera_from_child
            fit = LinkMeasure(link, self._symmetry(child, link.child)).fit(relative.matrix)
            q = q if self._is_rigid else fit.q
        structures.link(child, parent, joint, q)
        if is_seen[link.child] and not parent_is_seen:
            optimiser.carry_back(child, camera_from_child)
        root = structures.root(parent)
        optimiser.move(root, optimiser.pose(root))
        for member in structures.members(root):
            optimiser.activate(int(member))

    def _any_seen(self, body: int, is_seen: Mapping[str, bool]) -> bool:
        """Whether anything of the module of a body is seen."""
        members = {int(member) for member in self._optimiser.structures.members(body)}
        return any(is_seen[name] for name, i in self._index.items() if i in members)

    def _symmetry(self, body: int, name: str) -> Symmetry:
        alone = len(self._optimiser.structures.members(body)) == 1
        return self._parts[name].symmetry if alone else NO_SYMMETRY

    @staticmethod
    def _rigid(link: Link) -> Link:
        return link.model_copy(update={"joint": _RIGID})
