"""Small pictures of a rendered test split for a page: one of each asset and condition.

`python -m snapfit.models.workbench.pictures DATASET FOLDER`
"""

from __future__ import annotations

import itertools
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2

from snapfit.models.bop_writer import ENTRIES, make_folder, write_image
from snapfit.models.errors import DatasetError
from snapfit.models.pose import Pose
from snapfit.models.workbench.split import TEST_FRAMES, Condition

_WIDTH_PX, _QUALITY = 480, 78
# Where in the assembly each condition is shown, as shares of its frames.
_SHOWN_AT = {
    Condition.NORMAL: 0.02,
    Condition.DYNAMIC: 0.97,
    Condition.BLUR: 0.5,
    Condition.HAND: 0.45,
    Condition.ALL: 0.72,
}
_AROUND = 0.12
_HELD = (0.45, 0.9)


def small_pictures(dataset: Path, folder: Path) -> list[Path]:
    """Writes `ASSET-CONDITION.jpg` of all scenes of a test split.

    Args:
        dataset: as `render_dataset` writes it.
        folder: made if need be.

    Returns:
        The files.

    Raises:
        DatasetError: a scene or an image is missing, or the folder cannot be written.
    """
    make_folder(folder)
    made = []
    for name, condition in itertools.product(TEST_FRAMES, Condition):
        scene = dataset / name / "test" / condition
        path = scene / "rgb" / f"{shown_frame(scene, condition):06d}.jpg"
        image = cv2.imread(str(path))
        if image is None:
            raise DatasetError(path, "is missing or no image: render the dataset first")
        size = (_WIDTH_PX, round(image.shape[0] * _WIDTH_PX / image.shape[1]))
        small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        goal = folder / f"{name}-{condition}.jpg"
        write_image(goal, small, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        made.append(goal)
    return made


def shown_frame(scene: Path, condition: Condition) -> int:
    """The frame of a scene that shows its condition best, near a given moment."""
    n = len(list((scene / ENTRIES).glob("*.json")))
    if n == 0:
        raise DatasetError(scene, "has no finished frame: render the dataset first")
    middle, reach = round(_SHOWN_AT[condition] * n), round(_AROUND * n)
    near = range(max(middle - reach, 1), min(middle + reach, n))
    if condition in (Condition.NORMAL, Condition.DYNAMIC) or not near:
        return min(middle, n - 1)
    if condition is Condition.BLUR:
        return max(near, key=lambda i: _step_m(_entry(scene, i - 1), _entry(scene, i)))
    held = [i for i in near if _is_held(_entry(scene, i))]
    return min(held or near, key=lambda i: abs(i - middle))


def _entry(scene: Path, index: int) -> dict[str, Any]:
    path = scene / ENTRIES / f"{index:06d}.json"
    try:
        entry: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise DatasetError(path, "is missing or damaged: render the dataset first") from error
    return entry


def _step_m(before: Mapping[str, Any], now: Mapping[str, Any]) -> float:
    part = now["in_hand"]
    if part not in now["poses"]:
        return 0.0
    a, b = (Pose.from_matrix(entry["poses"][part]) for entry in (before, now))
    return a.distance_to(b)


def _is_held(entry: Mapping[str, Any]) -> bool:
    """Whether the part in hand is seen for a good part, but not all."""
    share = entry["visib"].get(entry["in_hand"], 0.0)
    return bool(_HELD[0] < share < _HELD[1])


def main(arguments: Sequence[str]) -> None:
    """Takes the dataset and the folder from the command line."""
    if len(arguments) != 2:
        raise SystemExit("usage: python -m snapfit.models.workbench.pictures DATASET FOLDER")
    try:
        small_pictures(Path(arguments[0]), Path(arguments[1]))
    except DatasetError as error:
        raise SystemExit(str(error)) from error


if __name__ == "__main__":
    main(sys.argv[1:])
