"""The settings: `snapfit.toml`, over it the environment (SNAPFIT_...), over it the command line."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator
from pydantic_settings import (
    BaseSettings,
    NoDecode,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
)

from snapfit.server.errors import SettingsError
from snapfit.server.worker_spec import AUTO, DEMO_SOURCE, ColorFormat
from snapfit.tracking.finding.names import DetectorWish, ProviderName

_NAME = r"^[A-Za-z0-9][A-Za-z0-9._-]*$"


class StationSettings(BaseModel):
    """One workbench: cameras and one asset under assembly."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(
        default="bench-1",
        pattern=_NAME,
        max_length=64,
        description="Name of the station in URLs: letters, digits, dot, dash, underscore.",
    )
    source: str = Field(
        default=DEMO_SOURCE,
        min_length=1,
        description="Where frames come from: a camera's address such as 'realsense:SERIAL', "
        "the folder of a recorded sequence or of a BOP scene, an MCAP recording, or 'demo', the "
        "simulated bench.",
    )
    asset: str | None = Field(
        default=None,
        min_length=1,
        description="The asset under assembly: name of a bundled one, or its folder. Not needed "
        "where the source names it.",
    )
    calibration: str | None = Field(
        default=None,
        min_length=1,
        description="Camera file of a USB or network camera, as snapfit calibrate writes it; "
        "other sources bring their calibration.",
    )
    method: str = Field(
        default=AUTO,
        min_length=1,
        description="The tracking method; 'auto' is gbot where the parts are those of an asset "
        "with an assembly graph, else icg.",
    )
    detector: DetectorWish = Field(
        default=AUTO,
        description="Finds the parts at the start and again where they are lost: 'network' (the "
        "asset's own), 'geometric' (their shape in the depth image), 'none' (the source brings "
        "the first poses), 'auto' (the first of these that there is).",
    )
    providers: Annotated[tuple[ProviderName, ...], NoDecode] = Field(
        default=("cpu",),
        description="What runs the network, the first choice first; what is not there is passed "
        "over and told in the log, down to the CPU.",
    )
    record: str | None = Field(
        default=None,
        min_length=1,
        description="Folder in which each run of the station is recorded as an MCAP file: what it "
        "saw and said. Not set: nothing is recorded.",
    )
    record_color: ColorFormat = Field(
        default="png",
        description="Colour in recordings: 'png' loses nothing, so that a replay gives the same "
        "poses; 'jpeg' takes a tenth of the room, and a replay gives nearly the same.",
    )
    stale_after_s: float = Field(
        default=0.5, gt=0, le=60, description="A snapshot older than this is stale, seconds."
    )

    @field_validator("providers", mode="before")
    @classmethod
    def _split(cls, value: Any) -> Any:
        """In the environment the names stand in one line, with commas."""
        return [name.strip() for name in value.split(",")] if isinstance(value, str) else value


class Settings(BaseSettings):
    """Everything that can be set."""

    model_config = SettingsConfigDict(
        extra="forbid", frozen=True, env_prefix="SNAPFIT_", env_nested_delimiter="__"
    )

    host: str = Field(
        default="127.0.0.1",
        min_length=1,
        description="Address to listen at; 0.0.0.0 for all of this machine's.",
    )
    port: int = Field(default=8000, ge=1, le=65535, description="Port to listen at.")
    station: StationSettings = Field(
        default_factory=StationSettings, description="The workbench that is served."
    )

    @classmethod
    def settings_customise_sources(
        cls,
        settings_cls: type[BaseSettings],
        init_settings: PydanticBaseSettingsSource,
        env_settings: PydanticBaseSettingsSource,
        dotenv_settings: PydanticBaseSettingsSource,
        file_secret_settings: PydanticBaseSettingsSource,
    ) -> tuple[PydanticBaseSettingsSource, ...]:
        """The environment goes over the file, whose values come through `init_settings`."""
        del settings_cls, dotenv_settings, file_secret_settings
        return env_settings, init_settings


def load_settings(path: Path) -> Settings:
    """The settings of a TOML file, with the environment over it.

    A relative `station.source` or asset folder counts from the file's folder.

    Raises:
        SettingsError: the file is missing or no TOML, a key is unknown, a value is refused.
    """
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise SettingsError(path, ["no such file"]) from error
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(path, [f"cannot be read: {error}"]) from error
    except tomllib.TOMLDecodeError as error:
        raise SettingsError(path, [f"is no TOML: {error}"]) from error
    _count_from(path.parent, values)
    return make_settings(path, values)


def make_settings(origin: Path | str, values: dict[str, Any]) -> Settings:
    """The settings of these values, with the environment over them.

    Raises:
        SettingsError: a key is unknown or a value is refused.
    """
    try:
        return Settings(**values)
    except ValidationError as error:
        raise SettingsError(origin, [_problem(detail) for detail in error.errors()]) from error


def with_station(settings: Settings, values: dict[str, Any]) -> Settings:
    """The settings with other values for the station, as the command line gives them.

    Raises:
        SettingsError: a value is refused.
    """
    try:
        station = StationSettings(**{**settings.station.model_dump(), **values})
    except ValidationError as error:
        problems = [_problem(detail) for detail in error.errors()]
        raise SettingsError("the command line", problems) from error
    return settings.model_copy(update={"station": station})


def _problem(detail: Any) -> str:
    key = ".".join(str(step) for step in detail["loc"]) or "settings"
    if detail["type"] == "extra_forbidden":
        model = StationSettings if key.startswith("station.") else Settings
        return f"{key}: unknown key; there are {', '.join(model.model_fields)}"
    return f"{key}: {detail['msg']}, this is {detail['input']!r}"


def _count_from(folder: Path, values: dict[str, Any]) -> None:
    """Make relative paths of the file count from where the file lies."""
    station = values.get("station")
    if not isinstance(station, dict):
        return
    for key in ("source", "asset", "calibration"):
        value = station.get(key)
        if isinstance(value, str) and (folder / value).exists():
            station[key] = str(folder / value)
    if isinstance(record := station.get("record"), str) and record:
        # It is made when there is something to record.
        station["record"] = str(folder / record)
