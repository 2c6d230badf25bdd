"""A board with two blocks that may be put on in either order, and ways of the blocks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from tracks import Track

from snapfit.models.asset import Asset, Part
from snapfit.models.manifest import Link, State, Step
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.symmetry import Symmetry
from snapfit.models.workbench.motion import minimum_jerk

ON_BOARD = {
    "left": Pose.from_translation(-0.05, 0, 0.02),
    "right": Pose.from_translation(0.05, 0, 0.02),
}
BESIDE = {
    "board": Pose.identity(),
    "left": Pose.from_translation(-0.15, 0.1, 0.01),
    "right": Pose.from_translation(0.15, 0.1, 0.01),
}


def block(name: str, size_m: tuple[float, float, float], **more: Any) -> Part:
    box = trimesh.creation.box(size_m)
    return Part(name, Mesh(box.vertices.astype(np.float32), box.faces.astype(np.int32)), **more)


def link(child: str, **more: Any) -> Link:
    return Link(parent="board", child=child, parent_from_child=ON_BOARD[child], **more)


def step(name: str, from_state: str, to_state: str) -> Step:
    ends = {"from_state": from_state, "to_state": to_state}
    return Step(name=name, title=name, text=name, parts=("board",), **ends)


def toy(left: Mapping[str, Any] | None = None, right: Mapping[str, Any] | None = None) -> Asset:
    """States free, left-on, right-on, both; by either way."""
    on_left, on_right = link("left", **(left or {})), link("right", **(right or {}))
    return Asset(
        name="toy",
        title="Toy",
        licence="CC0-1.0",
        directory=Path("toy"),
        parts=(
            block("board", (0.2, 0.08, 0.02)),
            block("left", (0.04, 0.03, 0.02)),
            block(
                "right", (0.05, 0.03, 0.02), symmetry=Symmetry((Pose.exp([0, 0, np.pi, 0, 0, 0]),))
            ),
        ),
        states=(
            State(name="free"),
            State(name="left-on", link=(on_left,)),
            State(name="right-on", link=(on_right,)),
            State(name="both", link=(on_left, on_right)),
        ),
        steps=(
            step("put-left", "free", "left-on"),
            step("put-right", "free", "right-on"),
            step("then-right", "left-on", "both"),
            step("then-left", "right-on", "both"),
        ),
    )


def carried(
    asset: Asset, ways: Sequence[tuple[str, Pose]], n_carry: int = 40, n_rest: int = 20
) -> Track:
    """Parts carried one after the other; the true state is by who stands in place."""
    now, poses = dict(BESIDE), [BESIDE] * n_rest
    for part, goal in ways:
        start = now[part]
        turn = (start.inverse() @ goal).log()[:3]
        for i in range(n_carry):
            share = minimum_jerk((i + 1) / n_carry)
            way = start.translation + share * (goal.translation - start.translation)
            way[2] += 0.12 * np.sin(np.pi * share)
            rotation = start.rotation @ Pose.exp([*(share * turn), 0, 0, 0]).rotation
            poses.append({**now, part: Pose.from_rotation_translation(rotation, way)})
        now[part] = goal
        poses += [dict(now)] * n_rest
    return Track(asset, poses, [_state(each) for each in poses])


def _state(poses: Mapping[str, Pose]) -> str:
    right = poses["right"].distance_to(ON_BOARD["right"]) < 1e-4
    left = poses["left"].distance_to(ON_BOARD["left"]) < 1e-4
    return {(0, 0): "free", (1, 0): "left-on", (0, 1): "right-on"}.get((left, right), "both")
