"""Looks for the boards that anchors need, in a side thread of the worker."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

import cv2

from snapfit.models.camera import PinholeCamera
from snapfit.server.boards import Board
from snapfit.server.marker_detection import MarkerDetector, MarkerPose
from snapfit.server.marker_message import MarkerMessage, SeenMarker
from snapfit.server.pose_store import PoseStore
from snapfit.tracking.frame import Frame

_PERIOD_S = 0.25
_LOG = logging.getLogger(__name__)


class MarkerWatch:
    """Detects boards in the latest frame, a few times a second, while somebody wants them.

    Args:
        store: where what was seen goes.
        boot_id: of this run of the worker.
        camera: of the frames' colour images.
        wanted: the boards that are wanted now.
    """

    def __init__(
        self,
        store: PoseStore,
        boot_id: str,
        camera: PinholeCamera,
        wanted: Callable[[], tuple[Board, ...]],
    ) -> None:
        self._store = store
        self._boot_id = boot_id
        self._camera = camera
        self._wanted = wanted
        self._detectors: dict[Board, MarkerDetector] = {}
        self._frame: Frame | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="snapfit-markers", daemon=True)
        self._thread.start()

    def offer(self, frame: Frame) -> None:
        """The latest frame."""
        self._frame = frame

    def close(self) -> None:
        """End the thread."""
        self._stop.set()
        self._thread.join()

    def _run(self) -> None:
        last: Frame | None = None
        while not self._stop.wait(_PERIOD_S):
            frame, boards = self._frame, self._wanted()
            if frame is None or frame is last or not boards:
                continue
            last = frame
            try:
                self._look(frame, boards)
            except cv2.error as error:  # this frame, not the next ones
                _LOG.warning("frame %s: no marker could be looked for: %s", frame.name, error)

    def _look(self, frame: Frame, boards: tuple[Board, ...]) -> None:
        gray = cv2.cvtColor(frame.color, cv2.COLOR_BGR2GRAY)
        seen = []
        for board in boards:
            detector = self._detectors.get(board)
            if detector is None:
                detector = self._detectors[board] = MarkerDetector(board, self._camera)
            found = detector.detect(gray)
            if found is not None:
                seen.append(_told(board, found))
        message = MarkerMessage(
            boot_id=self._boot_id, captured_at_us=frame.captured_at_ns // 1000, seen=tuple(seen)
        )
        self._store.markers.write(message.model_dump_json().encode())


def _told(board: Board, found: MarkerPose) -> SeenMarker:
    pose = found.camera_from_marker
    return SeenMarker(
        board=board,
        position=tuple(pose.translation.tolist()),
        orientation=tuple(pose.quaternion.tolist()),
        error_px=found.error_px,
        corners=found.corners,
    )
