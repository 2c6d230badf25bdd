"""Sets up logging for this process."""

from __future__ import annotations

import logging
import sys
from types import TracebackType
from typing import Literal, NamedTuple

from snapfit.server.logs.formats import JsonFormatter, TextFormatter

LogFormat = Literal["text", "json"]
LogLevel = Literal["debug", "info", "warning", "error"]
_LOG = logging.getLogger("snapfit")


class LogChoice(NamedTuple):
    """How this process logs, and the workers that it starts."""

    format: LogFormat = "text"
    level: LogLevel = "warning"


_chosen = LogChoice()


def configure_logging(choice: LogChoice, **members: str) -> None:
    """Log to standard error from now on, exceptions that nobody caught too.

    Args:
        choice: format, and level of our own events; of libraries' only warnings are logged.
        members: that every event of this process carries.
    """
    global _chosen
    _chosen = choice
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonFormatter() if choice.format == "json" else TextFormatter())
    handler.addFilter(_Members(members))
    level = logging.getLevelNamesMapping()[choice.level.upper()]
    logging.basicConfig(level=max(level, logging.WARNING), handlers=[handler], force=True)
    _LOG.setLevel(level)
    sys.excepthook = _log_uncaught


def chosen_logging() -> LogChoice:
    """What `configure_logging` was last told."""
    return _chosen


class _Members(logging.Filter):
    """Lets everything pass, with these members."""

    def __init__(self, members: dict[str, str]) -> None:
        super().__init__()
        self._members = members

    def filter(self, record: logging.LogRecord) -> bool:
        """Add them."""
        record.__dict__.update(self._members)
        return True


def _log_uncaught(
    kind: type[BaseException], error: BaseException, traceback: TracebackType | None
) -> None:
    if issubclass(kind, KeyboardInterrupt):
        sys.__excepthook__(kind, error, traceback)
        return
    _LOG.critical("ended by an error", exc_info=(kind, error, traceback))
