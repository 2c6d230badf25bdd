"""Which part lies where, when several may: at a place is one part."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from snapfit.models.pose import Pose
from snapfit.tracking.body import Body
from snapfit.tracking.finding.finder import Hypothesis


class Found(Protocol):
    """A pose, and how sure it is."""

    @property
    def camera_from_body(self) -> Pose:
        """The pose."""

    @property
    def score(self) -> float:
        """How sure it is, 0 to 1."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A pose of a part that explains what is seen at a place.

    Attributes:
        part: its name.
        shape: a number; parts with the same have the same mesh.
        pieces: numbers of what is explained; of two fits that share one, one is wrong.
        found: the pose, and what speaks for it.
    """

    part: str
    shape: int
    pieces: frozenset[int]
    found: Found


def in_order(fits: Sequence[Fit]) -> list[Hypothesis]:
    """Hypotheses, the surest first; each part's best place is one that no other part has.

    Parts that look the same get a place each, and after that the others' places too: who knows
    already where one of them is finds the other.
    """
    ordered = sorted(fits, key=lambda each: -each.found.score)
    placed: dict[str, Fit] = {}
    for fit in ordered:
        free = all(not fit.pieces & each.pieces for each in placed.values())
        if free and fit.part not in placed:
            placed[fit.part] = fit
    chosen = list(placed.values())
    rest = [fit for fit in ordered if fit not in chosen and _is_open(fit, chosen)]
    return [
        Hypothesis(fit.part, fit.found.camera_from_body, fit.found.score, is_refined=True)
        for fit in chosen + rest
    ]


def shapes(bodies: Sequence[Body]) -> dict[str, int]:
    """A number for each part; parts with the same mesh have the same."""
    found: dict[str, int] = {}
    for i, body in enumerate(bodies):
        same = (
            found[other.name]
            for other in bodies[:i]
            if np.array_equal(other.mesh.vertices, body.mesh.vertices)
        )
        found[body.name] = next(same, i)
    return found


def _is_open(fit: Fit, placed: Collection[Fit]) -> bool:
    """Whether no other part lies where a fit puts its part; one that looks the same may."""
    return all(
        each.shape == fit.shape
        for each in placed
        if each.pieces & fit.pieces and each.part != fit.part
    )
