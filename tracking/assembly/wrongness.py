"""In what way a part that rests on another one is wrong, if it is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from snapfit.models.joint import JointMotion
from snapfit.models.pose import Array
from snapfit.tracking.assembly.contact import Contacts
from snapfit.tracking.assembly.estimate import MisassemblyKind
from snapfit.tracking.assembly.graph import AssemblyGraph
from snapfit.tracking.assembly.link_error import LinkFit, LinkMeasure
from snapfit.tracking.assembly.parameters import AssemblyParameters
from snapfit.tracking.assembly.relations import Relations

_NAN = float("nan")
# A part takes the place of another if their middles are so near, in shares of their sizes.
_TAKES_SHARE, _TAKES_LEAST_M = 0.2, 0.012

Verdict = tuple[MisassemblyKind, float, float]
"""(kind, translation from its own place, m, rotation, rad; not a number without one)."""


@dataclass(frozen=True, eq=False)
class Situation:
    """All that is needed to judge a part.

    Attributes:
        graph: of the asset.
        state: that holds.
        relations: relative poses of all parts.
        contacts: sizes and middles of the parts.
        parameters: thresholds.
    """

    graph: AssemblyGraph
    state: str
    relations: Relations
    contacts: Contacts
    parameters: AssemblyParameters

    @property
    def next_links(self) -> tuple[LinkMeasure, ...]:
        """Links that the next steps make."""
        return self.graph.coming(self.state)

    def fit(self, measure: LinkMeasure) -> LinkFit | None:
        """A link measured, if both parts are seen."""
        link = measure.link
        if not self.relations.is_seen_of(link.parent, link.child):
            return None
        return measure.fit(self.relations.mean_of(link.parent, link.child))

    def is_fulfilled(self, fit: LinkFit | None) -> bool:
        """Whether a part is in its place, as far as tracking can tell."""
        if fit is None or not fit.is_within_tolerance:
            return False
        return fit.translation_m < self.parameters.fulfilled_m

    def next_is_open(self) -> bool:
        """Whether the next step is known not to be done: its parts are seen elsewhere.

        A part that lies where it lay at first needs no second look.
        """
        for measure in self.next_links:
            parent, child = measure.link.parent, measure.link.child
            if not self.relations.has_been_moved(child):
                continue
            if not self.relations.is_known_of(parent, child) or self.is_fulfilled(
                self.fit(measure)
            ):
                return False
        return True


def what_is_wrong(situation: Situation, part: str, is_touching: bool) -> Verdict | None:
    """Judges a part at rest against another one.

    Args:
        situation: what is known.
        part: that does not belong to the module.
        is_touching: whether it touches the module.

    Returns:
        None where nothing is wrong.
    """
    coming = [(each, situation.fit(each)) for each in _of(situation.next_links, part)]
    if any(situation.is_fulfilled(fit) for _, fit in coming):
        return None
    later = [(each, situation.fit(each)) for each in _of(_later(situation), part)]
    for measure, fit in later:
        if fit is not None and situation.is_fulfilled(fit) and _still(situation, measure):
            errors = fit.translation_m, fit.rotation_rad
            return (MisassemblyKind.WRONG_ORDER, *errors) if situation.next_is_open() else None
    if not is_touching:
        return None
    own = [(measure, fit) for measure, fit in coming + later if fit is not None]
    nearest = min((fit for _, fit in own), key=lambda fit: fit.translation_m, default=None)
    errors = (_NAN, _NAN) if nearest is None else (nearest.translation_m, nearest.rotation_rad)
    for measure, fit in own:
        is_turned = fit.rotation_rad > math.radians(measure.link.rotation_tolerance_deg)
        if is_turned and _is_at_place(situation, measure):
            return MisassemblyKind.WRONG_WAY_ROUND, fit.translation_m, fit.rotation_rad
    if _takes_a_place(situation, part):
        return (MisassemblyKind.WRONG_PART, *errors)
    return (MisassemblyKind.WRONG_PLACE, *errors)


def _of(measures: tuple[LinkMeasure, ...], part: str) -> list[LinkMeasure]:
    return [each for each in measures if part in (each.link.child, each.link.parent)]


def _later(situation: Situation) -> tuple[LinkMeasure, ...]:
    return situation.graph.later(situation.state)


def _still(situation: Situation, measure: LinkMeasure) -> bool:
    """Whether the parts of a link are at rest against each other, after they were moved."""
    relations = situation.relations
    pair, _ = relations.pair(measure.link.parent, measure.link.child)
    is_resting = relations.still_frames[pair] >= situation.parameters.wrong_frames
    return bool(is_resting and relations.has_moved[pair])


def _is_at_place(situation: Situation, measure: LinkMeasure) -> bool:
    """Whether the middle of a part is where it belongs, however the part is turned."""
    link, contacts = measure.link, situation.contacts
    center_m = contacts.center_m[link.child]
    parent_from_child = situation.relations.mean_of(link.parent, link.child)
    measured = parent_from_child[:3, :3] @ center_m + parent_from_child[:3, 3]
    goal = measure.goal.inverse()
    tolerance_m = min(link.translation_tolerance_m, max(contacts.radius_m[link.child] / 2, 0.012))
    return _aside_m(goal.transform(measured), center_m, measure.joint) < tolerance_m


def _aside_m(point: Array, center: Array, joint: JointMotion) -> float:
    """How far a point is from where a joint may bring another one; both in the child's zero."""
    apart = point - center
    along = float(apart @ joint.axis)
    across = apart - along * joint.axis
    if joint.type.turns:
        # On a circle about the axis: the difference of the radii is left.
        radii = [
            float(np.linalg.norm(np.cross(joint.axis, each - joint.point_m)))
            for each in (point, center)
        ]
        across_m = abs(radii[0] - radii[1])
    else:
        across_m = float(np.linalg.norm(across))
    if joint.type.slides:
        low, high = sorted(joint.limits[-1] * (joint.pitch_m / math.tau if joint.pitch_m else 1))
        along -= min(max(along, low), high)
    return math.hypot(across_m, along)


def _takes_a_place(situation: Situation, part: str) -> bool:
    """Whether a part sits where the next step puts another one."""
    relations, contacts = situation.relations, situation.contacts
    for measure in situation.next_links:
        link = measure.link
        if part in (link.child, link.parent) or not relations.is_seen_of(link.parent, part):
            continue
        if situation.is_fulfilled(situation.fit(measure)):
            continue
        pose = relations.mean_of(link.parent, part)
        here = pose[:3, :3] @ contacts.center_m[part] + pose[:3, 3]
        there = contacts.center_m[link.child]
        sizes = contacts.diameter_m[part] + contacts.diameter_m[link.child]
        limit_m = max(_TAKES_SHARE * sizes / 2, _TAKES_LEAST_M)
        if _aside_m(measure.goal.inverse().transform(here), there, measure.joint) < limit_m:
            return True
    return False
