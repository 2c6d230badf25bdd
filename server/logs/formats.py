"""How an event is written: as JSON for machines, as text for people."""

from __future__ import annotations

import logging
from datetime import UTC, datetime
from typing import Any

import orjson

from snapfit.server.logs.context import request_id
from snapfit.server.logs.secrets import without_secrets

_USUAL = frozenset(logging.makeLogRecord({}).__dict__) | {"message", "asctime", "taskName"}


class JsonFormatter(logging.Formatter):
    """An event is one JSON object in one line: at, level, logger, message, and its own members."""

    def format(self, record: logging.LogRecord) -> str:
        """The line."""
        event: dict[str, Any] = {
            "at": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "process": record.process,
            "message": record.getMessage(),
            **members(record),
        }
        if record.exc_info:
            event["exception"] = self.formatException(record.exc_info)
        return without_secrets(orjson.dumps(event, default=str).decode())


class TextFormatter(logging.Formatter):
    """Time, level, message, and an event's own members; a traceback in lines below."""

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)s %(message)s")

    def format(self, record: logging.LogRecord) -> str:
        """The text."""
        told = " ".join(f"{name}={value}" for name, value in members(record).items() if value)
        head, newline, below = super().format(record).partition("\n")
        return without_secrets(
            f"{head} [{told}]{newline}{below}" if told else head + newline + below
        )


def members(record: logging.LogRecord) -> dict[str, Any]:
    """What an event carries beside its message: `extra`, and the request that it belongs to."""
    found = {name: value for name, value in record.__dict__.items() if name not in _USUAL}
    current = request_id.get()
    return found if current is None else {"request_id": current, **found}
