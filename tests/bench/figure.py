"""A measured figure beside the bound that it has to keep."""

from __future__ import annotations

from typing import NamedTuple


class Figure(NamedTuple):
    """A measured figure and its bound.

    Attributes:
        name: what was measured.
        value, unit: the figure.
        bound: what it has to keep, in words; "" for a figure that only informs.
        is_kept: whether it does; None without a bound.
    """

    name: str
    value: float
    unit: str
    bound: str = ""
    is_kept: bool | None = None


def at_most(name: str, value: float, unit: str, most: float) -> Figure:
    """A figure with an upper bound."""
    return Figure(name, value, unit, f"<= {most:g} {unit}", value <= most)


def at_least(name: str, value: float, unit: str, least: float) -> Figure:
    """A figure with a lower bound."""
    return Figure(name, value, unit, f">= {least:g} {unit}", value >= least)
