"""The steps of a station's asset, as they stand now."""

from __future__ import annotations

from http import HTTPStatus
from typing import Any

from snapfit.server.answers import SnapshotAnswers
from snapfit.server.asset_library import ExportedAsset, step_along
from snapfit.server.conventions import AXES
from snapfit.server.problems import ProblemError
from snapfit.server.rigid import Rigid
from snapfit.server.schemas_assembly import (
    PlacedPose,
    StationStep,
    StepAnswer,
    StepInfo,
    StepList,
    StepProgress,
)
from snapfit.server.view import View


class StationSteps:
    """The steps at one snapshot, in one view.

    Args:
        answers: the snapshot.
        asset: that is assembled.
        view: how poses are given.
        stale: whether the snapshot is not to be relied on.

    Raises:
        ProblemError: 404, nothing follows the assembly here.
    """

    def __init__(
        self, answers: SnapshotAnswers, asset: ExportedAsset, view: View, *, stale: bool
    ) -> None:
        self._snapshot = answers.snapshot
        self._assembly = assembly_of(answers)
        self._asset = asset
        self._view = view
        self._stale = stale

    def all(self) -> StepList:
        """All of them, in the order of the manifest."""
        steps = [self._at_station(step) for step in self._asset.info.steps]
        return StepList(**self._header(), steps=steps)

    def current(self) -> StepAnswer:
        """The first one that can be taken now.

        Raises:
            ProblemError: 404, the assembly is finished.
        """
        following = self._assembly["next_steps"]
        if not following:
            state = self._assembly["state"]
            detail = f"Nothing is left to do: the assembly is in its last state, {state!r}."
            raise ProblemError(HTTPStatus.NOT_FOUND, "assembly-finished", detail, state=state)
        return self.named(following[0])

    def named(self, name: str) -> StepAnswer:
        """One of them.

        Raises:
            ProblemError: 404; lists the steps.
        """
        step = self._at_station(self._asset.step(name))
        others = [each for each in self._assembly["next_steps"] if each != name]
        return StepAnswer(**self._header(), step=step, alternatives=others)

    def _header(self) -> dict[str, Any]:
        known = ("station", "asset", "boot_id", "seq", "captured_at_us")
        return {
            **{key: self._snapshot[key] for key in known},
            "stale": self._stale,
            "frame": self._view.frame,
            "convention": self._view.convention,
            "state": self._assembly["state"],
        }

    def _at_station(self, step: StepInfo) -> StationStep:
        converted = step_along(AXES[self._view.convention], step)
        return StationStep(
            **converted.model_dump(),
            progress=self._progress(step.step),
            ghost_in_frame=self._ghost(step),
        )

    def _progress(self, step: str) -> StepProgress:
        if step in self._assembly["finished_steps"]:
            return StepProgress.FINISHED
        return StepProgress.NEXT if step in self._assembly["next_steps"] else StepProgress.LATER

    def _ghost(self, step: StepInfo) -> PlacedPose | None:
        """`frame_from_ghost`, where the part that carries it is."""
        ghost = step.ghost
        if ghost is None:
            return None
        parent = next((it for it in self._snapshot["parts"] if it["part"] == ghost.parent), None)
        if parent is None or parent["position"] is None or parent["orientation"] is None:
            return None
        pose = Rigid(parent["position"], parent["orientation"])
        pose = self._view.pose(pose @ Rigid(ghost.position, ghost.orientation))
        return PlacedPose(position=list(pose.position), orientation=list(pose.orientation))


def assembly_of(answers: SnapshotAnswers) -> dict[str, Any]:
    """JSON of the snapshot's `AssemblySummary`.

    Raises:
        ProblemError: 404, nothing follows the assembly here.
    """
    assembly: dict[str, Any] | None = answers.snapshot.get("assembly")
    if assembly is None:
        raise no_assembly(answers.snapshot["station"])
    return assembly


def no_assembly(station: str) -> ProblemError:
    """404, nothing follows the assembly here."""
    return ProblemError(
        HTTPStatus.NOT_FOUND,
        "no-assembly",
        f"Nothing follows an assembly at station {station}: its asset has no states and steps, or "
        "its method tracks single parts (gbot follows them).",
    )


def no_asset(station: str) -> ProblemError:
    """503, the asset is not here."""
    return ProblemError(
        HTTPStatus.SERVICE_UNAVAILABLE,
        "no-asset-yet",
        f"The steps of station {station} are not here: its worker has not handed its asset over "
        "yet, or its cache cannot be written, which its log tells then.",
        retry_after_s=1,
    )
