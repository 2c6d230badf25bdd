"""A camera as a source: the newest frame wins, and a camera that went away is looked for again."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass

from snapfit.models.asset import Asset, Part
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.errors import FrameError, SourceError
from snapfit.tracking.frame import Frame
from snapfit.tracking.sources.driver import CameraDriver, CameraLostError, Images, LensedCamera
from snapfit.tracking.sources.image_watch import ImageWatch
from snapfit.tracking.sources.lens import Undistortion

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class LiveTimes:
    """How long to wait for what, s.

    Attributes:
        read_s: for one frame, before it is looked whether the source was closed.
        answer_s: `read` answers after this, with a frame or with what is wrong.
        silent_s: a camera that delivers nothing for so long is connected anew.
        first_delay_s: before a camera that is gone is looked for; doubles each time.
        longest_delay_s: up to here.
        close_s: for a driver that does not come back when the source is closed.
    """

    read_s: float = 0.5
    answer_s: float = 0.5
    silent_s: float = 5.0
    first_delay_s: float = 0.5
    longest_delay_s: float = 10.0
    close_s: float = 3.0


class LiveCamera:
    """A camera as a source of frames; see `Source` and `LiveSource`.

    A thread takes the camera's frames as they come. Who reads gets the newest one; older ones
    are let go. Frames are stamped when they arrive.
    """

    is_live = True
    initial_poses: Mapping[str, Pose] = {}

    def __init__(
        self, name: str, driver: CameraDriver, asset: Asset | None, times: LiveTimes | None = None
    ) -> None:
        """Connects to the camera.

        Args:
            name: shown to people.
            driver: of the camera; used here alone.
            asset: with the parts that are to be tracked; None where frames alone are wanted.
            times: how long to wait for what.

        Raises:
            SourceError: there is no such camera, or it cannot be used.
        """
        self.name, self.asset = name, asset
        self.parts: tuple[Part, ...] = () if asset is None else asset.tracked_parts
        self._driver, self._times = driver, times or LiveTimes()
        try:
            self._lensed = driver.open()
        except BaseException:
            driver.close()
            raise
        self._undistortion, self._watch = Undistortion(self._lensed), ImageWatch(self._lensed)
        self._changed = threading.Condition()
        self._news: Frame | FrameError | None = None
        self._state = "has delivered nothing yet"
        self._number = 0
        self._delay_s = self._times.first_delay_s
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)
        self._thread.start()

    @property
    def camera(self) -> RgbdCamera:
        """The camera of every frame, its distortion undone."""
        return self._lensed.undistorted

    @property
    def frame_rate_hz(self) -> float:
        """Frames a second, as the camera promises them."""
        return self._lensed.frame_rate_hz

    def read(self) -> Frame | None:
        """The newest frame that was not read yet, waited for; None once closed.

        Raises:
            FrameError: it cannot be used, or none comes: the camera hangs, or is gone and looked
                for.
        """
        with self._changed:
            self._changed.wait_for(
                lambda: self._news is not None or self._closed.is_set(), self._times.answer_s
            )
            news, self._news = self._news, None
            if self._closed.is_set():
                return None
            if news is None:
                raise FrameError(f"{self._number:06d}", f"the camera {self._state}")
        if isinstance(news, FrameError):
            raise news
        return news

    def close(self) -> None:
        """Lets go of the camera; may be called twice."""
        with self._changed:
            self._closed.set()
            self._changed.notify_all()
        self._thread.join(self._times.close_s)

    def _run(self) -> None:
        try:
            while not self._closed.is_set():
                try:
                    self._stream()
                except CameraLostError as error:
                    self._find_again(str(error))
        except Exception:  # noqa: BLE001
            # A bug in a driver must not look like a camera that is quiet.
            _LOG.exception("the camera's thread ended: a bug")
            self._state = "cannot be read any more: a bug, told in the log"
        finally:
            self._driver.close()

    def _stream(self) -> None:
        """Takes frames until the source is closed.

        Raises:
            CameraLostError: the camera is gone, or was silent for too long.
        """
        heard_at_s = time.monotonic()
        while not self._closed.is_set():
            images = self._driver.read(self._times.read_s)
            now_s = time.monotonic()
            if images is not None:
                heard_at_s = now_s
                self._take(images)
            elif now_s - heard_at_s >= self._times.silent_s:
                raise CameraLostError(f"has delivered nothing for {self._times.silent_s:g} s")

    def _take(self, images: Images) -> None:
        arrived_at_ns = time.monotonic_ns()
        name = f"{self._number:06d}"
        problem = self._watch.problem(images)
        news: Frame | FrameError
        if problem is not None:
            news = FrameError(name, problem)
        else:
            images = self._undistortion.undo(images)
            news = Frame(name, arrived_at_ns, images.color, images.depth)
        if self._delay_s > self._times.first_delay_s:
            _LOG.warning("camera %s: is there again", self.name)
            self._delay_s = self._times.first_delay_s
        self._number += 1
        self._tell(news, f"is slow: no frame for {self._times.answer_s:g} s")

    def _tell(self, news: Frame | FrameError, state: str) -> None:
        with self._changed:
            self._news, self._state = news, state
            self._changed.notify_all()

    def _find_again(self, reason: str) -> None:
        """Looks for the camera until it can be opened again, or the source is closed.

        The delay starts over when frames come, not before: a camera may be there and silent.
        """
        state = f"is gone ({reason}): looking for it"
        if self._delay_s == self._times.first_delay_s:
            _LOG.warning("camera %s: %s; looking for it again", self.name, reason)
        self._tell(FrameError(f"{self._number:06d}", f"the camera {state}"), state)
        while not self._closed.is_set():
            self._driver.close()
            if self._closed.wait(self._delay_s):
                return
            self._delay_s = min(2 * self._delay_s, self._times.longest_delay_s)
            try:
                self._take_back(self._driver.open())
            except SourceError as error:
                self._state = f"is gone ({error}): looking for it"
                continue
            return

    def _take_back(self, lensed: LensedCamera) -> None:
        if not lensed.is_like(self._lensed):
            raise CameraLostError(f"another camera answers, {lensed.name}")
        self._watch = ImageWatch(self._lensed)
        self._state = "is there again and has delivered nothing yet"
