"""Places of parts where an image cannot tell whether the part is there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from scipy.spatial import cKDTree

from snapfit.models.asset import Part
from snapfit.models.manifest import State
from snapfit.tracking.assembly.contact import surface_samples
from snapfit.tracking.body import alike

_FLAT_M, _FLAT_SHARE = 0.008, 0.5


def unclear_places(parts: Sequence[Part], states: Iterable[State]) -> frozenset[str]:
    """Parts that in their place lie flat on a part of like colour.

    A cover on a plate of its own colour has no contour against it, and depth differs by less than
    the sensor's error: whether it is there or not, colour and depth agree with it.

    Args:
        parts: tracked parts.
        states: of the assembly graph.
    """
    index = {part.name: i for i, part in enumerate(parts)}
    same = alike([part.color_rgb for part in parts])
    places = {(link.parent, link.child): link for state in states for link in state.links}
    unclear = set()
    for (parent, child), link in places.items():
        if parent not in index or child not in index or not same[index[parent], index[child]]:
            continue
        tree = cKDTree(surface_samples(parts[index[parent]].mesh))
        placed = link.parent_from_child.transform(surface_samples(parts[index[child]].mesh))
        away_m, _ = tree.query(placed)
        if (away_m < _FLAT_M).mean() > _FLAT_SHARE:
            unclear.add(child)
    return frozenset(unclear)
