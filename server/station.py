"""A station as the API sees it: its latest snapshot, its pictures, its worker's health."""

from __future__ import annotations

import time
from http import HTTPStatus
from pathlib import Path
from typing import Any

from snapfit.server.anchors import Anchor
from snapfit.server.answers import Answer, SnapshotAnswers
from snapfit.server.asset_library import ExportedAsset
from snapfit.server.clock import Clock
from snapfit.server.command_desk import CommandDesk
from snapfit.server.fleet.keepers import Back, back_here
from snapfit.server.picture_desk import PictureDesk
from snapfit.server.picture_message import PictureMessage
from snapfit.server.pose_store import Picture, PoseStore
from snapfit.server.problems import ProblemError
from snapfit.server.schemas import StationFacts, StationInfo, WorkerHealth, WorkerReport
from snapfit.server.settings import StationSettings
from snapfit.server.station_news import StationNews
from snapfit.server.station_spec import station_spec
from snapfit.server.steps import StationSteps, assembly_of, no_assembly, no_asset
from snapfit.server.view import PLAIN, View
from snapfit.server.watch import Moment, Watch
from snapfit.server.worker_health import worker_health

_ANCHOR_WAIT_S = 2.0
_RETRY_AFTER_S = 1


def unknown_part(station: str, name: str, parts: list[str]) -> ProblemError:
    """404; lists the parts that there are."""
    return ProblemError(
        HTTPStatus.NOT_FOUND,
        "unknown-part",
        f"Station {station} has no part {name!r}; it has {', '.join(parts)}.",
        parts=parts,
    )


class Station:
    """Owns the pose store and the supervised worker of one workbench.

    Attributes:
        name: in paths.
        watch: wakes whoever waits for the next snapshot.
        commands: what the worker is ordered to do.
        news: what happened here, and clients' worlds.
    """

    def __init__(
        self,
        settings: StationSettings,
        clock: Clock,
        pipeline: str,
        back: Back = back_here,
    ) -> None:
        self.name = settings.name
        self._clock = clock
        self._stale_after_s = settings.stale_after_s
        self._stale_after_us = round(settings.stale_after_s * 1e6)
        self._store = PoseStore.create()
        spec = station_spec(settings, clock, self._store.names, pipeline)
        backing = back(spec, self._store)
        self._supervisor = backing.keeper
        self._shelf = backing.shelf
        self._pictures = PictureDesk(self.name, self._store, self._is_up)
        self.commands = CommandDesk(self.name, self._store, self._why_down)
        self.news = StationNews(self.name, self._store, clock, self.commands, self._shelf)
        self._answers: SnapshotAnswers | None = None
        self._facts: StationFacts | None = None
        self._asset: ExportedAsset | None = None
        self.watch = Watch(
            self.moment, self._on_moment, lambda: self.news.events.latest, self._store.doorbell
        )

    def start(self) -> None:
        """Start the worker."""
        self._supervisor.start()

    def close(self) -> None:
        """End the worker and remove the store."""
        self._supervisor.close()
        self._shelf.close()
        self._store.close()

    def moment(self) -> Moment | None:
        """Which snapshot is the latest, and whether it is stale; None before the first one."""
        answers = self._newest()
        if answers is None:
            return None
        return Moment(answers.boot_id, answers.seq, self._is_stale(answers), answers.revision)

    def snapshot(self) -> dict[str, Any] | None:
        """JSON of the latest snapshot, to be read only; None before the first one."""
        answers = self._newest()
        return None if answers is None else answers.snapshot

    def latest_snapshot(self) -> dict[str, Any]:
        """The same, where there has to be one.

        Raises:
            ProblemError: 503 before the first snapshot.
        """
        return self._latest().snapshot

    def poses(self, view: View = PLAIN, at_us: int | None = None) -> Answer:
        """All parts in the latest snapshot, as somebody wants to see them.

        Raises:
            ProblemError: 503 before the first snapshot.
        """
        answers = self._latest()
        return answers.all_parts(stale=self._is_stale(answers), view=view, at_us=at_us)

    def part(self, name: str, view: View = PLAIN, at_us: int | None = None) -> Answer:
        """One part in the latest snapshot, likewise.

        Raises:
            ProblemError: 503 before the first snapshot, 404 for an unknown part.
        """
        answers = self._latest()
        answer = answers.one_part(name, stale=self._is_stale(answers), view=view, at_us=at_us)
        if answer is None:
            raise unknown_part(self.name, name, answers.part_names)
        return answer

    def assembly(self) -> Answer:
        """The assembly at the latest snapshot.

        Raises:
            ProblemError: 503 before the first snapshot, 404 where nothing follows the assembly.
        """
        answers = self._latest()
        answer = answers.assembly(stale=self._is_stale(answers))
        if answer is None:
            raise no_assembly(self.name)
        return answer

    def steps(self, view: View) -> StationSteps:
        """The steps of its asset at the latest snapshot.

        Raises:
            ProblemError: 503 before the first snapshot and before the asset is here, 404 where
                nothing follows the assembly.
        """
        answers = self._latest()
        stale = self._is_stale(answers)
        assembly_of(answers)
        asset = self.asset()
        if asset is None:
            raise no_asset(self.name)
        return StationSteps(answers, asset, view, stale=stale)

    def asset(self) -> ExportedAsset | None:
        """What is assembled here; None for loose parts, and until the worker has opened it."""
        report = self._report()
        folder = None if report is None else report.asset_folder
        if folder is not None and (self._asset is None or str(self._asset.folder) != folder):
            self._asset = ExportedAsset(Path(folder))
        return self._asset

    async def picture(self, kind: Picture) -> PictureMessage:
        """A picture of the latest snapshot or a later one; waits for it, at most a second.

        Raises:
            ProblemError: 503 when there is none in time.
        """
        return await self._pictures.picture(kind, self._latest().generation)

    @property
    def is_refused(self) -> bool:
        """Whether the worker has given up for good, because of a file or a setting."""
        return self._supervisor.status.refused

    def is_ready(self) -> bool:
        """Whether there is a fresh snapshot."""
        answers = self._newest()
        return answers is not None and not self._is_stale(answers)

    def info(self) -> StationInfo:
        """What the station is like, and how its worker does."""
        report = self._report()
        if report is not None and report.facts is not None:
            self._facts = report.facts
        return StationInfo(
            station=self.name,
            stale_after_s=self._stale_after_s,
            stale=not self.is_ready(),
            facts=self._facts,
            worker=self._health(report),
        )

    def _is_up(self) -> bool:
        return self._supervisor.status.pid is not None

    def _why_down(self) -> str | None:
        status = self._supervisor.status
        return None if status.pid is not None else status.absent or "it is down"

    def _health(self, report: WorkerReport | None) -> WorkerHealth:
        return worker_health(self._supervisor.status, report)

    def _report(self) -> WorkerReport | None:
        message = self._store.reports.read()
        return None if message is None else WorkerReport.model_validate_json(message.payload)

    def now_us(self) -> int:
        """The server's time, Unix, microseconds."""
        return self._clock.now_us()

    async def wait_for_anchor(self, anchor: Anchor) -> None:
        """Until the camera has seen the anchor's board; gives up after two seconds."""
        give_up_at_s = time.monotonic() + _ANCHOR_WAIT_S
        while len(anchor.view.poses) == 0 and time.monotonic() < give_up_at_s:
            if not await self.watch.change(_ANCHOR_WAIT_S):
                return
            self.news.anchors.update()

    def _on_moment(self) -> None:
        answers = self._newest()
        stale = answers is not None and self._is_stale(answers)
        self.news.take_in(answers, stale=stale)

    def _newest(self) -> SnapshotAnswers | None:
        answers = self._answers
        if answers is None or answers.generation != self._store.snapshots.latest:
            message = self._store.snapshots.read()
            if message is None:
                return None
            answers = self._answers = SnapshotAnswers(*message)
        return answers

    def _latest(self) -> SnapshotAnswers:
        answers = self._newest()
        if answers is None:
            worker = self._health(self._report())
            raise ProblemError(
                HTTPStatus.SERVICE_UNAVAILABLE,
                "no-poses-yet",
                f"Station {self.name} has tracked no frame yet: {worker.message}.",
                retry_after_s=_RETRY_AFTER_S,
                worker=worker.model_dump(),
            )
        return answers

    def _is_stale(self, answers: SnapshotAnswers) -> bool:
        return (
            self._clock.now_us() - answers.captured_at_us > self._stale_after_us
            or answers.boot_id != self._supervisor.status.boot_id
        )
