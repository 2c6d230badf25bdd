"""The exported assets as the API sees them: read once, converted on request."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from http import HTTPStatus
from pathlib import Path
from typing import TypeVar

from snapfit.server.asset_paths import INFO_NAME, media_file, media_path, part_file
from snapfit.server.conventions import AXES, Axes, Convention
from snapfit.server.problems import ProblemError
from snapfit.server.rigid import Rigid
from snapfit.server.schemas_assembly import AssetInfo, PlacedPose, StepInfo

Placed = TypeVar("Placed", bound=PlacedPose)


@dataclass(frozen=True)
class ExportedAsset:
    """An asset in the cache.

    Attributes:
        folder: that the worker wrote.
    """

    folder: Path

    @cached_property
    def info(self) -> AssetInfo:
        """In OpenCV's axes.

        Raises:
            ProblemError: 503, the cache was deleted meanwhile.
        """
        try:
            return AssetInfo.model_validate_json((self.folder / INFO_NAME).read_bytes())
        except OSError as error:
            raise _gone(self.folder.name) from error

    def info_in(self, convention: Convention) -> AssetInfo:
        """In the axes of a convention."""
        axes = AXES[convention]
        states = [
            state.model_copy(update={"links": [along(axes, link) for link in state.links]})
            for state in self.info.states
        ]
        steps = [step_along(axes, step) for step in self.info.steps]
        changes = {"convention": convention, "states": states, "steps": steps}
        return self.info.model_copy(update=changes)

    def step(self, name: str) -> StepInfo:
        """A step by its name.

        Raises:
            ProblemError: 404; lists the steps.
        """
        names = [step.step for step in self.info.steps]
        if name not in names:
            raise ProblemError(
                HTTPStatus.NOT_FOUND,
                "unknown-step",
                f"Asset {self.info.asset} has no step {name!r}; it has {', '.join(names)}.",
                steps=names,
            )
        return self.info.steps[names.index(name)]

    def mesh(self, part: str) -> tuple[bytes, str]:
        """A part's glTF binary, and its SHA-256.

        Raises:
            ProblemError: 404; lists the parts.
        """
        known = {each.part: each for each in self.info.parts}
        if part not in known:
            raise ProblemError(
                HTTPStatus.NOT_FOUND,
                "unknown-part",
                f"Asset {self.info.asset} has no part {part!r}; it has {', '.join(known)}.",
                parts=list(known),
            )
        try:
            return part_file(self.folder, part).read_bytes(), known[part].mesh_sha256
        except OSError as error:
            raise _gone(self.info.asset) from error

    def media(self, name: str) -> Path:
        """A picture or film that a step names.

        Raises:
            ProblemError: 404, no step names it.
        """
        path = media_path(self.info.asset, name)
        if not any(path in step.media for step in self.info.steps):
            detail = f"No step of asset {self.info.asset} names {name!r}."
            raise ProblemError(HTTPStatus.NOT_FOUND, "unknown-media", detail)
        file = media_file(self.folder, name)
        if not file.is_file():
            raise _gone(self.info.asset)
        return file


def _gone(asset: str) -> ProblemError:
    return ProblemError(
        HTTPStatus.SERVICE_UNAVAILABLE,
        "asset-gone",
        f"A file of asset {asset} is not here. It was deleted from the cache: start the server "
        "again; or it is too large for the store between machines, as the worker's log tells.",
    )


def along(axes: Axes, placed: Placed) -> Placed:
    """The same place in another convention's components."""
    position, orientation = Rigid(placed.position, placed.orientation).along(axes)
    return placed.model_copy(update={"position": position, "orientation": orientation})


def step_along(axes: Axes, step: StepInfo) -> StepInfo:
    """The same step in another convention's components."""
    annotations = [
        each.model_copy(update={"anchor": axes.vector(each.anchor)}) for each in step.annotations
    ]
    ghost = None if step.ghost is None else along(axes, step.ghost)
    return step.model_copy(update={"ghost": ghost, "annotations": annotations})
