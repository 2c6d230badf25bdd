"""Writes an MCAP file so that whatever was written stays readable, whoever kills the process.

The mcap package's own writer ends a chunk when it is large enough; here a chunk ends when its
writer says so, and goes to the operating system at once and whole. The records are the package's.
Format: https://mcap.dev/spec.
"""

from __future__ import annotations

import os
import time
import zlib
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Message,
    MessageIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

MAGIC = b"\x89MCAP0\r\n"
_SYNC_EVERY_S = 2.0


class McapWriter:
    """One file in the making: channels, attachments, messages in chunks, and at the end an index.

    Attributes:
        path: the file.
        n_bytes: how much of it is written.
    """

    def __init__(self, path: Path) -> None:
        """Begins a file.

        Raises:
            OSError: it is there already, or cannot be written.
        """
        self.path, self.n_bytes = path, 0
        self._file = path.open("xb", buffering=0)
        self._synced_at_s = time.monotonic()
        self._schemas: dict[str, Schema] = {}
        self._channels: list[Channel] = []
        # Packed at once: an hour has some 200,000 of them.
        self._chunk_index = bytearray()
        self._n_chunks = 0
        self._first_ns: int | None = None
        self._last_ns = 0
        self._attachments: list[AttachmentIndex] = []
        self._counts: dict[int, int] = defaultdict(int)
        self._open_chunk()
        self._write(MAGIC + _packed(Header(profile="", library="snapfit")))

    def add_channel(
        self, topic: str, schema: str, schema_encoding: str, schema_data: bytes, encoding: str
    ) -> int:
        """Makes a channel; its number.

        Args:
            topic: its name.
            schema: name of its messages' type.
            schema_encoding, schema_data: what describes that type ("protobuf", "jsonschema").
            encoding: of the messages ("protobuf", "json").
        """
        if schema not in self._schemas:
            number = len(self._schemas) + 1
            self._schemas[schema] = Schema(
                id=number, data=schema_data, encoding=schema_encoding, name=schema
            )
            self._schemas[schema].write(self._builder)
        channel = Channel(
            id=len(self._channels) + 1,
            topic=topic,
            message_encoding=encoding,
            schema_id=self._schemas[schema].id,
            metadata={},
        )
        channel.write(self._builder)
        self._channels.append(channel)
        return int(channel.id)

    def attach(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Writes an attachment, at once.

        Raises:
            OSError: it cannot be written; the file ends before it.
        """
        offset = self.n_bytes
        packed = _packed(
            Attachment(
                create_time=time_ns, log_time=time_ns, name=name, media_type=media_type, data=data
            )
        )
        self._write(packed)
        index = AttachmentIndex(
            offset=offset,
            length=len(packed),
            create_time=time_ns,
            log_time=time_ns,
            data_size=len(data),
            name=name,
            media_type=media_type,
        )
        self._attachments.append(index)

    def add(self, channel: int, time_ns: int, data: bytes) -> None:
        """Puts a message into the open chunk.

        Args:
            channel: its number.
            time_ns: Unix time, ns.
            data: encoded as the channel says.
        """
        self._index[channel].append((time_ns, self._builder.count))
        Message(
            channel_id=channel, log_time=time_ns, data=data, publish_time=time_ns, sequence=0
        ).write(self._builder)

    def end_chunk(self) -> None:
        """Writes the open chunk, whole, and opens the next; nothing where it is empty.

        Raises:
            OSError: it cannot be written; the file ends with the chunk before.
        """
        if not self._builder.count:
            return
        times = [time_ns for entries in self._index.values() for time_ns, _ in entries] or [0]
        data, index = self._builder.end(), dict(self._index)
        self._open_chunk()
        # Images are compressed already: once more would cost time and gain nothing.
        chunk = Chunk(
            compression="",
            data=data,
            message_start_time=min(times),
            message_end_time=max(times),
            uncompressed_crc=zlib.crc32(data),
            uncompressed_size=len(data),
        )
        packed, offset = _packed(chunk), self.n_bytes
        offsets, indexes = {}, b""
        for channel, entries in index.items():
            offsets[channel] = offset + len(packed) + len(indexes)
            indexes += _packed(MessageIndex(channel_id=channel, records=entries))
        self._write(packed + indexes)
        for channel, entries in index.items():
            self._counts[channel] += len(entries)
        self._chunk_index += _packed(
            ChunkIndex(
                chunk_length=len(packed),
                chunk_start_offset=offset,
                compression="",
                compressed_size=len(data),
                message_end_time=max(times),
                message_index_length=len(indexes),
                message_index_offsets=offsets,
                message_start_time=min(times),
                uncompressed_size=len(data),
            )
        )
        self._n_chunks += 1
        self._first_ns = min(times) if self._first_ns is None else min(self._first_ns, *times)
        self._last_ns = max(self._last_ns, *times)
        self._sync_now_and_then()

    def finish(self) -> None:
        """Writes what is left and the index, and closes the file.

        Raises:
            OSError: there is no room for it; the file ends with the last whole chunk.
        """
        try:
            self.end_chunk()
            self._write(self._summary())
        finally:
            self._file.close()

    def close(self) -> None:
        """Closes the file as it is, without an index."""
        self._file.close()

    def _open_chunk(self) -> None:
        self._builder = RecordBuilder()
        self._index: dict[int, list[tuple[int, int]]] = defaultdict(list)

    def _write(self, data: bytes) -> None:
        """All of it, or the file stays as it was."""
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError:
            self._file.truncate(self.n_bytes)
            raise
        self.n_bytes += len(data)

    def _sync_now_and_then(self) -> None:
        """A killed process loses nothing without this; a machine without power does."""
        if time.monotonic() - self._synced_at_s >= _SYNC_EVERY_S:
            os.fsync(self._file.fileno())
            self._synced_at_s = time.monotonic()

    def _summary(self) -> bytes:
        end = _packed(DataEnd(0))
        start = self.n_bytes + len(end)
        groups = [
            (Opcode.SCHEMA, _all_packed(self._schemas.values())),
            (Opcode.CHANNEL, _all_packed(self._channels)),
            (Opcode.STATISTICS, _packed(self._statistics())),
            (Opcode.CHUNK_INDEX, bytes(self._chunk_index)),
            (Opcode.ATTACHMENT_INDEX, _all_packed(self._attachments)),
        ]
        body, offsets = b"", b""
        for opcode, group in groups:
            offset = SummaryOffset(
                group_opcode=opcode, group_start=start + len(body), group_length=len(group)
            )
            body, offsets = body + group, offsets + _packed(offset)
        footer = Footer(summary_start=start, summary_offset_start=start + len(body), summary_crc=0)
        return end + body + offsets + _packed(footer) + MAGIC

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=self._n_chunks,
            message_count=sum(self._counts.values()),
            metadata_count=0,
            message_start_time=self._first_ns or 0,
            message_end_time=self._last_ns,
            schema_count=len(self._schemas),
        )


def _all_packed(records: Iterable[McapRecord]) -> bytes:
    return b"".join(_packed(record) for record in records)


def _packed(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
