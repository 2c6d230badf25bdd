"""What the benchmark has to know of a method beside its name."""

from __future__ import annotations

from collections.abc import Sequence

from snapfit.tracking.errors import TrackingError
from snapfit.tracking.methods import METHODS


def check_methods(methods: Sequence[str]) -> None:
    """Makes sure that there are such methods, before anything is read.

    Raises:
        TrackingError: none, or one that there is not.
    """
    known = ", ".join(METHODS)
    if not methods:
        raise TrackingError(f"no method to benchmark: name some of {known}")
    for method in methods:
        if method not in METHODS:
            raise TrackingError(f"there is no method {method!r}; the methods are {known}")


def entry(method: str) -> object:
    """What the table of methods says of a method."""
    return METHODS[method]


def summary(method: str) -> str:
    """What a method is, in a line; empty where the table of methods does not say."""
    told, step = str(getattr(METHODS.get(method), "summary", "")), frame_step(method)
    return told if step == 1 else f"{told}; judged on every {step}th frame"


def needs_true_state(method: str) -> bool:
    """Whether a method is told the true assembly state of each frame: it tracks one structure."""
    return bool(getattr(entry(method), "needs_true_state", False))


def starts_cold(method: str) -> bool:
    """Whether a method is given no first poses: it finds the parts by itself."""
    return bool(getattr(METHODS.get(method), "is_cold", False))


def finds_parts(method: str) -> bool:
    """Whether a method finds parts that it was given no pose of."""
    return bool(getattr(METHODS.get(method), "finds_parts", False))


def frame_step(method: str) -> int:
    """Of how many frames a method is shown one: over 1 for those that remember nothing."""
    return int(getattr(METHODS.get(method), "frame_step", 1))


def is_told_poses(method: str) -> bool:
    """Whether a method is given first poses, and remembers from them which part is which."""
    return not starts_cold(method) and frame_step(method) == 1


def follows_states(method: str) -> bool:
    """Whether a method follows the assembly state by itself, and can be told where it begins."""
    graph = getattr(METHODS.get(method), "graph", None)
    return graph is not None and not graph.is_told


def ablations(methods: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """By method that something is left out of: itself and those that leave something out.

    Args:
        methods: those that were run, in the order of the tables.
    """
    groups: dict[str, tuple[str, ...]] = {}
    for method in methods:
        whole = str(getattr(METHODS.get(method), "ablation_of", "") or "")
        if whole in methods:
            groups[whole] = (*groups.get(whole, (whole,)), method)
    return groups
