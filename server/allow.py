"""Which methods a path has: the header Allow of a 405."""

from __future__ import annotations

import re
from functools import cached_property
from typing import Any

from fastapi import FastAPI


class AllowedMethods:
    """Knows all documented paths of an app; a router alone knows one route at a time.

    Args:
        app: whose document tells them.
    """

    def __init__(self, app: FastAPI) -> None:
        self._app = app

    def at(self, path: str) -> list[str]:
        """The methods of a path, sorted; none for one that is not documented."""
        found = {
            method for pattern, known in self._paths if pattern.match(path) for method in known
        }
        return sorted(found)

    def prepare(self) -> None:
        """Look at the document now, and not when somebody asks first."""
        _ = self._paths

    @cached_property
    def _paths(self) -> list[tuple[re.Pattern[str], list[str]]]:
        paths: dict[str, Any] = self._app.openapi()["paths"]
        return [
            (re.compile(_PARAMETER.sub("[^/]+", path) + "$"), [it.upper() for it in operations])
            for path, operations in paths.items()
        ]


_PARAMETER = re.compile(r"\{[^}]*\}")
