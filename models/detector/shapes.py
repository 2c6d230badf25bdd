"""What has to be known of a part to label it in a turned view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from snapfit.models.asset import Asset
from snapfit.models.errors import DatasetError
from snapfit.models.pose import Array
from snapfit.models.symmetry import Symmetry
from snapfit.models.train_reader import TrainClass


@dataclass(frozen=True, eq=False)
class PartShape:
    """A part as the labels need it.

    Attributes:
        number: of its class, from 0.
        keypoints_m: (K, 3) body frame, m.
        hull_m: (N, 3) corners of its convex hull, body frame, m.
        symmetry: of the part.
    """

    number: int
    keypoints_m: Array
    hull_m: Array
    symmetry: Symmetry


def part_shapes(
    asset: Asset, classes: Sequence[TrainClass], first: int = 0
) -> dict[str, PartShape]:
    """By name, the classes of a training set; their numbers go from `first` upwards.

    Raises:
        DatasetError: the set has a part that the asset has not.
    """
    parts = {part.name: part for part in asset.parts}
    shapes = {}
    for number, each in enumerate(classes, first):
        if each.part not in parts:
            problem = f"has no part {each.part!r}, but the training set has: render it again"
            raise DatasetError(asset.directory, problem)
        part = parts[each.part]
        shapes[each.part] = PartShape(
            number, each.keypoints_m, part.mesh.hull_points, part.symmetry
        )
    return shapes
