"""Which estimate is of which part, where parts are made alike.

Who is given no first pose cannot tell parts of one mesh apart: they are instances of one object,
and each frame's estimates go to those that they are nearest to, as in the BOP challenge (Hodan et
al., 2020). Who was told which part is which is to know it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from scipy.optimize import linear_sum_assignment

from snapfit.models.asset import Part
from snapfit.models.pose import Array, Pose

_FAR_M = 1e3


def instances(parts: Sequence[Part]) -> list[list[int]]:
    """Columns of parts of one mesh, more than one each."""
    groups: dict[str, list[int]] = {}
    for column, part in enumerate(parts):
        groups.setdefault(part.mesh.digest, []).append(column)
    return [group for group in groups.values() if len(group) > 1]


def matched(
    poses: Array, truths: Sequence[Mapping[str, Pose]], parts: Sequence[Part]
) -> npt.NDArray[np.int64]:
    """Whose estimate counts as whose.

    Args:
        poses: (F, P, 4, 4) `camera_from_body` as estimated; not a number without an estimate.
        truths: the true ones of each frame, by part.
        parts: in the order of the columns.

    Returns:
        (F, P) for each part the column of its estimate: each column once a frame, and a part's own
        unless it has others like it.
    """
    columns = np.tile(np.arange(len(parts)), (len(poses), 1))
    for group in instances(parts):
        for frame, truth in enumerate(truths):
            places = np.array([truth[parts[i].name].translation for i in group])
            away_m = np.linalg.norm(places[:, None] - poses[frame, group, :3, 3], axis=2)
            _, order = linear_sum_assignment(np.where(np.isfinite(away_m), away_m, _FAR_M))
            columns[frame, group] = np.array(group)[order]
    return columns
