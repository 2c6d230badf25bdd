"""Reads an MCAP file, whole or cut off: it is walked from its beginning, no index is needed."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Message, Schema
from mcap.stream_reader import breakup_chunk

from snapfit.tracking.errors import RecordingError
from snapfit.tracking.recording.mcap_writer import MAGIC

_HEAD = struct.Struct("<BQ")
# What reading records raises on bytes that are none.
_DAMAGED = (McapError, struct.error, ValueError, KeyError, IndexError, UnicodeDecodeError)


@dataclass(frozen=True)
class ChunkPlace:
    """Where a chunk lies in its file.

    Attributes:
        offset, length: of its content, bytes.
        channels: that it holds messages of, as the index behind it says.
    """

    offset: int
    length: int
    channels: frozenset[int] = frozenset()


class McapFile:
    """An MCAP file that is open for reading; safe to use from one thread at a time.

    Attributes:
        path: the file.
        chunks: where its whole chunks lie, in order.
        attachments: their content, by name.
        problem: what is missing at its end; None for a file that was finished.
    """

    def __init__(self, path: Path) -> None:
        """Opens a file and finds its chunks; reads no message.

        Raises:
            RecordingError: it is missing, or no MCAP file.
        """
        self.path = path
        try:
            self._file = path.open("rb")
            size = path.stat().st_size
        except OSError as error:
            raise RecordingError(path, f"cannot be read: {error.strerror}") from error
        if self._file.read(len(MAGIC)) != MAGIC:
            self._file.close()
            raise RecordingError(path, "is no MCAP file")
        self.chunks: list[ChunkPlace] = []
        self.attachments: dict[str, bytes] = {}
        self.problem: str | None = None
        self._topics: dict[int, str] = {}
        self._schemas: dict[int, str] = {}
        self._types: dict[int, str] = {}
        self._find_chunks(size)

    def topic(self, channel: int) -> str:
        """The topic of a channel, once the chunk that makes it has been read."""
        return self._topics.get(channel, "")

    def schema(self, channel: int) -> str:
        """The name of the type of a channel's messages; likewise."""
        return self._types.get(channel, "")

    def messages(self, place: ChunkPlace) -> list[Message]:
        """The messages of a chunk, in order.

        Raises:
            RecordingError: the chunk is damaged.
        """
        self._file.seek(place.offset)
        try:
            chunk = Chunk.read(ReadDataStream(BytesIO(self._file.read(place.length))))
            records = breakup_chunk(chunk, validate_crc=True)
        except (*_DAMAGED, zlib.error) as error:
            problem = f"is damaged at byte {place.offset}: {type(error).__name__} {error}"
            raise RecordingError(self.path, problem) from error
        found = []
        for record in records:
            if isinstance(record, Schema):
                self._schemas[record.id] = record.name
            elif isinstance(record, Channel):
                self._topics[record.id] = record.topic
                self._types[record.id] = self._schemas.get(record.schema_id, "")
            elif isinstance(record, Message):
                found.append(record)
        return found

    def close(self) -> None:
        """Closes it; may be called twice."""
        self._file.close()

    def _find_chunks(self, size: int) -> None:
        last_opcode = None
        for opcode, offset, length in self._records(size):
            last_opcode = opcode
            if opcode == Opcode.CHUNK:
                self.chunks.append(ChunkPlace(offset, length))
            elif opcode == Opcode.MESSAGE_INDEX and self.chunks:
                self._file.seek(offset)
                channel = int.from_bytes(self._file.read(2), "little")
                last = self.chunks[-1]
                self.chunks[-1] = replace(last, channels=last.channels | {channel})
            elif opcode == Opcode.ATTACHMENT:
                self._read_attachment(offset, length)
        if last_opcode != Opcode.FOOTER and self.problem is None:
            self.problem = f"was not finished: it ends after {size} bytes with its last whole chunk"

    def _records(self, size: int) -> Iterator[tuple[int, int, int]]:
        """Kind, offset of the content and length of each whole record; up to the footer."""
        at = len(MAGIC)
        while at < size:
            self._file.seek(at)
            head = self._file.read(_HEAD.size)
            length = _HEAD.unpack(head)[1] if len(head) == _HEAD.size else size
            if at + _HEAD.size + length > size:
                self.problem = (
                    f"was not finished: its last record is cut off, {size - at} of its {size} "
                    "bytes are lost, all before them is there"
                )
                return
            yield head[0], at + _HEAD.size, length
            if head[0] == Opcode.FOOTER:
                return
            at += _HEAD.size + length

    def _read_attachment(self, offset: int, length: int) -> None:
        self._file.seek(offset)
        try:
            found = Attachment.read(ReadDataStream(BytesIO(self._file.read(length))))
        except _DAMAGED as error:
            problem = f"has a damaged attachment at byte {offset}: {error}"
            raise RecordingError(self.path, problem) from error
        self.attachments[found.name] = found.data
