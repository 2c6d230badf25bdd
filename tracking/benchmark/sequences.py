"""Finds the sequences of a dataset, and opens one only if a benchmark can rely on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from snapfit.models.asset import Asset, find_asset
from snapfit.models.bop import CAMERA_NAME, TRUTH_NAME, read_json
from snapfit.models.errors import SequenceError
from snapfit.models.gbot_dataset import PAPER_CONDITIONS, is_gbot_scene, load_gbot_scene
from snapfit.models.recording import Recording
from snapfit.models.sequence import SEQUENCE_NAME, read_record
from snapfit.tracking.sources.recorded import load_recording

SPLIT = "test"
MASKS = "mask_visib"
ALONE = "recorded"
"""The condition of a single recorded sequence."""

CONDITIONS = (*PAPER_CONDITIONS, "all")
"""In the order of the tables; others come after them, by name."""


@dataclass(frozen=True)
class SequenceFolder:
    """Where a sequence lies and what it is called in the tables.

    Attributes:
        asset: the asset's name.
        condition: as in the paper: normal, dynamic, hand, blur; or another.
        directory: its folder.
    """

    asset: str
    condition: str
    directory: Path

    @property
    def name(self) -> str:
        """For file names."""
        return f"{self.asset}-{self.condition}"


def find_sequences(
    data: Path, assets: Sequence[str] = (), conditions: Sequence[str] = ()
) -> tuple[SequenceFolder, ...]:
    """The sequences of a dataset: `ASSET/test/CONDITION`, or one recorded sequence alone.

    Args:
        data: the dataset's folder, or that of a sequence.
        assets: only these; all if empty.
        conditions: only these; all if empty.

    Raises:
        SequenceError: no sequence there, or none of an asset or condition that is asked for.
    """
    if not data.is_dir():
        raise SequenceError(data, "no such folder: --data is a dataset or a recorded sequence")
    if _is_sequence(data):
        found = [SequenceFolder(_asset_name(data), _condition_name(data), data)]
    else:
        folders = (each for each in data.glob(f"*/{SPLIT}/*") if _is_sequence(each))
        found = [SequenceFolder(each.parents[1].name, each.name, each) for each in folders]
    if not found:
        problem = f"holds no sequence: neither {SEQUENCE_NAME} nor ASSET/{SPLIT}/CONDITION folders"
        raise SequenceError(data, problem)
    _check_known(data, "asset", assets, {each.asset for each in found})
    _check_known(data, "condition", conditions, {each.condition for each in found})
    kept = [
        each
        for each in found
        if (not assets or each.asset in assets) and (not conditions or each.condition in conditions)
    ]
    if not kept:
        asked = f"{', '.join(assets)} under {', '.join(conditions)}"
        raise SequenceError(data, f"has no sequence of {asked}")
    return tuple(sorted(kept, key=lambda each: (each.asset, condition_order(each.condition))))


def condition_order(condition: str) -> tuple[int, str]:
    """Sorts conditions as the paper's tables do."""
    known = condition in CONDITIONS
    return (CONDITIONS.index(condition) if known else len(CONDITIONS), condition)


def open_sequence(folder: SequenceFolder, most_frames: int | None = None) -> Recording:
    """Opens a sequence and makes sure that every frame and the truth of every part is there.

    Args:
        folder: as found.
        most_frames: only so many, from the first.

    Raises:
        SequenceError: a file is missing, or frames and ground truth do not match.
        ManifestError, MeshError: a part is refused.
    """
    recording = _load(folder.directory)
    _check_counts(recording)
    _check_masks(recording.directory)
    frames = recording.frames[:most_frames]
    names = [part.name for part in recording.parts]
    for frame in frames:
        for path in (frame.color, frame.depth):
            if path is not None and not path.is_file():
                raise SequenceError(path, f"no such file: frame {frame.name} is incomplete")
        poses = recording.truth[frame.name].camera_from_body
        missing = [name for name in names if name not in poses]
        if missing:
            problem = f"frame {frame.name}: the ground truth has no {', '.join(missing)}"
            raise SequenceError(recording.directory, problem)
    first = recording.truth[frames[0].name].camera_from_body
    return replace(recording, frames=frames, initial_poses={name: first[name] for name in names})


def _load(directory: Path) -> Recording:
    if not (directory / SEQUENCE_NAME).is_file() and is_gbot_scene(directory):
        return load_gbot_scene(directory)
    return load_recording(directory, _asset_of_bop(directory))


def _asset_of_bop(directory: Path) -> Asset | None:
    """The asset of a BOP scene by its folder's name; None where the dataset brings meshes."""
    if (directory / SEQUENCE_NAME).is_file():
        return None
    if any((each / "models").is_dir() for each in (directory, *directory.parents[:2])):
        return None
    return find_asset(directory.absolute().parents[1].name)


def _check_counts(recording: Recording) -> None:
    frames = {frame.name for frame in recording.frames}
    truths = recording.truth.keys() | _images_with_truth(recording)
    without, beyond = sorted(frames - truths), sorted(truths - frames)
    if not without and not beyond:
        return
    problem = f"{len(frames)} frames, but ground truth of {len(truths)}"
    if without:
        problem += f"; without truth: {_shortened(without)}"
    if beyond:
        problem += f"; without images: {_shortened(beyond)}"
    raise SequenceError(recording.directory, problem)


def _check_masks(directory: Path) -> None:
    """Of a BOP scene with masks every one must be there: who lost one may have lost more."""
    path, folder = directory / TRUTH_NAME, directory / MASKS
    if not folder.is_dir() or not path.is_file():
        return
    there = {each.name for each in folder.iterdir()}
    for image, instances in read_json(path, TypeAdapter(dict[int, list[Any]])).items():
        for i in range(len(instances)):
            name = f"{image:06d}_{i:06d}.png"
            if name not in there:
                raise SequenceError(folder / name, "no such file: the dataset is incomplete")


def _images_with_truth(recording: Recording) -> set[str]:
    """Names of all images that a BOP scene's truth speaks of; its reader keeps only those there."""
    path = recording.directory / TRUTH_NAME
    if (recording.directory / SEQUENCE_NAME).is_file() or not path.is_file():
        return set()
    digits = len(recording.frames[0].name)
    return {f"{image:0{digits}d}" for image in read_json(path, TypeAdapter(dict[int, Any]))}


def _shortened(names: Sequence[str]) -> str:
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return ", ".join(names[:3]) + more


def _check_known(data: Path, what: str, asked: Sequence[str], there: set[str]) -> None:
    for name in asked:
        if name not in there:
            known = ", ".join(sorted(there))
            raise SequenceError(data, f"has no {what} {name!r}; it has: {known}")


def _is_sequence(folder: Path) -> bool:
    return any((folder / name).is_file() for name in (SEQUENCE_NAME, CAMERA_NAME))


def _asset_name(directory: Path) -> str:
    directory = directory.absolute()
    if (directory / SEQUENCE_NAME).is_file():
        asset = read_record(directory / SEQUENCE_NAME).asset
        if asset is not None:
            return asset
    in_dataset = directory.parent.name == SPLIT
    return directory.parents[1].name if in_dataset else directory.name


def _condition_name(directory: Path) -> str:
    directory = directory.absolute()
    return directory.name if directory.parent.name == SPLIT else ALONE
