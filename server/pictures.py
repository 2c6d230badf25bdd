"""JPEG pictures on demand, in a side thread of the worker that never delays tracking."""

from __future__ import annotations

import logging
import threading
from typing import NamedTuple

import cv2

from snapfit.server.errors import StoreError
from snapfit.server.picture_message import pack_picture
from snapfit.server.pipeline import Pipeline
from snapfit.server.pose_store import Picture, PoseStore
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import TrackingResult

_JPEG_QUALITY = 80
_PERIOD_S = 1 / 15
_LOG = logging.getLogger(__name__)


class _Job(NamedTuple):
    frame: Frame
    result: TrackingResult
    generation: int


class PictureMaker:
    """Encodes the latest frame, plain or drawn in, while somebody wants it.

    At most 15 times a second, and never the same frame twice.
    """

    def __init__(self, store: PoseStore, pipeline: Pipeline) -> None:
        self._store = store
        self._pipeline = pipeline
        self._latest: _Job | None = None
        self._made = dict.fromkeys(Picture, 0)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="snapfit-pictures", daemon=True)
        self._thread.start()

    def offer(self, frame: Frame, result: TrackingResult, generation: int) -> None:
        """The latest frame, its result, and the generation of its snapshot in the store."""
        self._latest = _Job(frame, result, generation)

    def close(self) -> None:
        """End the thread."""
        self._stop.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._stop.wait(_PERIOD_S):
            job = self._latest
            if job is None:
                continue
            for kind in Picture:
                if self._made[kind] < job.generation and self._store.wanted(kind):
                    self._made[kind] = job.generation
                    try:
                        self._make(kind, job)
                    except (StoreError, cv2.error) as error:  # this picture, not the next ones
                        _LOG.warning("frame %s: no %s.jpg: %s", job.frame.name, kind, error)

    def _make(self, kind: Picture, job: _Job) -> None:
        image = job.frame.color
        if kind is Picture.OVERLAY:
            image = self._pipeline.draw(image, job.result)
        encoded, jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
        if not encoded:
            _LOG.warning("frame %s: could not be encoded as %s.jpg", job.frame.name, kind)
            return
        message = pack_picture(job.generation, job.result.captured_at_ns // 1000, jpeg.tobytes())
        self._store.pictures[kind].write(message)
