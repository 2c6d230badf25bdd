"""Opens a recording: what was known, what came, what was said; images are decoded on demand."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import orjson
from pydantic import ValidationError

from snapfit.models.asset import Asset, Part, find_asset
from snapfit.models.errors import ManifestError, PoseError
from snapfit.tracking.errors import FrameError, RecordingError
from snapfit.tracking.frame import Frame, check_frame
from snapfit.tracking.recording import foxglove
from snapfit.tracking.recording.images import decode
from snapfit.tracking.recording.mcap_reader import ChunkPlace, McapFile
from snapfit.tracking.recording.records import (
    COLOR_TOPIC,
    DEPTH_TOPIC,
    LOG_TOPIC,
    RESULT_TOPIC,
    STATION_TOPIC,
    ResultRecord,
    StationRecord,
    camera_of,
)
from snapfit.tracking.recording.station import loose_part


@dataclass(frozen=True)
class RecordedResult:
    """A frame of a recording; of hours of them little more can be kept in memory.

    Attributes:
        number: counts the frames that came.
        frame: its name.
        captured_at_ns: time of exposure, Unix time, ns.
        place: where what was said of it lies.
        images: where its images lie; None where they were not recorded.
    """

    number: int
    frame: str
    captured_at_ns: int
    place: ChunkPlace
    images: ChunkPlace | None


class OpenRecording:
    """A recording that is open.

    Attributes:
        path: the file.
        station: what was known before the first frame.
        camera: of every frame.
        results: every frame that came, in order.
        log: the lines of the log.
        problem: what is missing at the file's end; None where nothing is.
    """

    def __init__(self, path: Path) -> None:
        """Opens a file and reads all but its images.

        Raises:
            RecordingError: it is missing, no recording of a station, or damaged.
        """
        self.path = path
        self._file = McapFile(path)
        self._lock = threading.Lock()
        self.problem = self._file.problem
        self.results: list[RecordedResult] = []
        self.log: list[str] = []
        try:
            self.station = self._read_station()
            self.camera = camera_of(self.station)
            self._read_all()
        except BaseException:
            self._file.close()
            raise

    @property
    def n_unrecorded(self) -> int:
        """Frames that came and have no images here."""
        return sum(each.images is None for each in self.results)

    def record(self, result: RecordedResult) -> ResultRecord:
        """What is written of a frame.

        Raises:
            RecordingError: it is damaged, or of another version of snapfit.
        """
        try:
            data = dict(self._messages(result.place))[RESULT_TOPIC]
            return ResultRecord.model_validate_json(data)
        except ValidationError as error:
            problem = f"frame {result.frame}: is of another version of snapfit: {error}"
            raise RecordingError(self.path, problem) from error

    def frame(self, result: RecordedResult) -> Frame:
        """The images of a frame; safe to use from any thread.

        Raises:
            FrameError: they were not recorded, or are damaged.
        """
        color, depth = self.encoded(result)
        if color is None:
            raise FrameError(result.frame, "was not recorded: there was no time to write it")
        frame = Frame(
            result.frame,
            result.captured_at_ns,
            decode(result.frame, "colour", color, np.uint8, 3),
            None if depth is None else decode(result.frame, "depth", depth, np.uint16, 2),
        )
        check_frame(frame, self.camera)
        return frame

    def encoded(self, result: RecordedResult) -> tuple[bytes | None, bytes | None]:
        """The colour and the depth image of a frame as they are in the file; None: not there.

        Raises:
            FrameError: they are damaged.
        """
        if result.images is None:
            return None, None
        try:
            messages = dict(self._messages(result.images))
        except RecordingError as error:
            raise FrameError(result.frame, error.problem) from error
        color, depth = messages.get(COLOR_TOPIC), messages.get(DEPTH_TOPIC)
        return (
            None if color is None else foxglove.image_data(color),
            None if depth is None else foxglove.image_data(depth),
        )

    def asset(self, given: Asset | None = None) -> Asset | None:
        """The asset under assembly: the given one, or the one that the recording names.

        Raises:
            RecordingError: the one that it names is not here.
            MeshError: one of its meshes is refused.
        """
        name = self.station.asset
        if given is not None or name is None:
            return given
        try:
            return find_asset(name)
        except ManifestError as error:
            problem = f"its asset {name!r} is not here ({error.problem}): name one with --asset"
            raise RecordingError(self.path, problem) from error

    def parts(self, asset: Asset | None) -> tuple[Part, ...]:
        """The parts to be tracked, of an asset or those that the recording brings.

        Raises:
            RecordingError: there are none, or a mesh in the recording is damaged.
        """
        if asset is not None:
            return asset.tracked_parts
        try:
            return tuple(loose_part(each, self._file.attachments) for each in self.station.parts)
        except (ValueError, PoseError) as error:
            raise RecordingError(self.path, f"has a part that cannot be used: {error}") from error

    def close(self) -> None:
        """Closes the file; may be called twice."""
        with self._lock:
            self._file.close()

    def _read_station(self) -> StationRecord:
        if not self._file.chunks:
            raise RecordingError(self.path, "holds no frame: it ends before its first chunk")
        for topic, data in self._messages(self._file.chunks[0]):
            if topic == STATION_TOPIC:
                try:
                    return StationRecord.model_validate_json(data)
                except ValidationError as error:
                    problem = f"is of another version of snapfit: {error.errors()[0]['msg']}"
                    raise RecordingError(self.path, problem) from error
        raise RecordingError(self.path, "is an MCAP file, but no recording of a station")

    def _read_all(self) -> None:
        images: ChunkPlace | None = None
        for place in self._file.chunks[1:]:
            if self._holds_images(place):
                images = place
                continue
            try:
                self._read_chunk(place, images)
            except (RecordingError, KeyError, orjson.JSONDecodeError) as error:
                # What is before it can still be used.
                self.problem = f"is damaged: nothing after frame {len(self.results)} is read"
                if not self.results:
                    raise RecordingError(self.path, "its first frame is damaged") from error
                return

    def _holds_images(self, place: ChunkPlace) -> bool:
        return any(self._file.topic(channel) == COLOR_TOPIC for channel in place.channels)

    def _read_chunk(self, place: ChunkPlace, images: ChunkPlace | None) -> None:
        for topic, data in self._messages(place):
            if topic == RESULT_TOPIC:
                told = orjson.loads(data)
                seen = images if told["has_images"] else None
                names = told["number"], told["frame"], told["captured_at_ns"]
                self.results.append(RecordedResult(*names, place, seen))
            elif topic == LOG_TOPIC:
                self.log.append(foxglove.log_text(data))

    def _messages(self, place: ChunkPlace) -> Iterator[tuple[str, bytes]]:
        with self._lock:
            messages = self._file.messages(place)
        for message in messages:
            yield self._file.topic(message.channel_id), message.data
