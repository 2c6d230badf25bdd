"""What an operator can ask for, and what the API answers."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from snapfit.server.schemas_base import Schema

Name = Annotated[str, Field(min_length=1, max_length=64)]


class ReinitialiseRequest(Schema):
    """Which parts are to be looked for again."""

    parts: list[Name] = Field(default=[], max_length=64, description="Their names; empty for all.")


class StateRequest(Schema):
    """Which assembly state holds."""

    state: Name = Field(description="Its name; GET /v1/assets/{asset} lists them.")


class CommandResult(Schema):
    """What was done."""

    station: str
    command: str
    changed: bool = Field(description="False where all was so already.")
    done: list[str] = Field(description="What was done, for people.")
    state: str | None = Field(description="The assembly state that holds now.")
