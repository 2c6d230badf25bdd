"""The settings: `snapfit.toml`, over it the environment (SNAPFIT_...), over it the command line."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator
from pydantic_settings import (
    BaseSettings,
    NoDecode,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
)

from snapfit.server.errors import SettingsError
from snapfit.server.fleet.keepers import MEMORY
from snapfit.server.logs.secrets import without_secrets
from snapfit.server.logs.setup import LogFormat, LogLevel
from snapfit.server.security.settings import SecuritySettings
from snapfit.server.worker_spec import AUTO, DEMO_SOURCE, ColorFormat
from snapfit.tracking.finding.names import DetectorWish, ProviderName

_Table = TypeVar("_Table", bound=BaseModel)
_STORE = r"^(memory|(redis|rediss|valkey|valkeys|unix)://\S+)$"
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
    niceness: int = Field(
        default=0,
        ge=0,
        le=19,
        description="By how much the station's worker is less urgent than the API and than other "
        "programs of this machine: 0 is alike, with 19 it has little but what they leave. Not on "
        "Windows.",
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
    gbot_port: int | None = Field(
        default=None,
        ge=1,
        le=65535,
        description="A second port that serves /resource alone, for clients made for the GBOT "
        "authors' server; theirs is 1984.",
    )
    store: str = Field(
        default=MEMORY,
        pattern=_STORE,
        description="Where workers and API meet: 'memory', this machine's shared memory, or the "
        "address of a Redis or Valkey, redis://[:PASSWORD@]HOST:PORT/DB, for several machines.",
    )
    log_format: LogFormat = Field(
        default="text",
        description="How logs are written to standard error: text, or JSON, an object a line.",
    )
    log_level: LogLevel = Field(
        default="warning",
        description="What is logged: info adds requests that change something or are refused, "
        "debug all requests.",
    )
    station: StationSettings = Field(
        default_factory=StationSettings, description="The workbench that is served."
    )
    stations: tuple[StationSettings, ...] = Field(
        default=(),
        max_length=32,
        description="Several workbenches, each a table [[stations]] with the keys of [station], in "
        "place of it; in the environment a JSON list.",
    )
    security: SecuritySettings = Field(
        default_factory=SecuritySettings, description="Who may ask, how much, and from where."
    )

    @model_validator(mode="after")
    def _check_stations(self) -> Settings:
        names = [station.name for station in self.stations]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"stations have to differ in name: {', '.join(twice)} is there twice")
        if names and "station" in self.model_fields_set:
            raise ValueError("station and stations are both set: move station into the list")
        return self

    @property
    def all_stations(self) -> tuple[StationSettings, ...]:
        """Every workbench that is served."""
        return self.stations or (self.station,)

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
    """The settings with other values for every station, as the command line gives them.

    Raises:
        SettingsError: a value is refused.
    """
    if settings.stations:
        stations = tuple(_with(station, values) for station in settings.stations)
        return settings.model_copy(update={"stations": stations})
    return settings.model_copy(update={"station": _with(settings.station, values)})


def with_security(settings: Settings, values: dict[str, Any]) -> Settings:
    """The settings with other values for security, as the command line gives them.

    Raises:
        SettingsError: a value is refused.
    """
    return settings.model_copy(update={"security": _with(settings.security, values)})


def _with(table: _Table, values: dict[str, Any]) -> _Table:
    try:
        return type(table)(**{**table.model_dump(), **values})
    except ValidationError as error:
        problems = [_problem(detail) for detail in error.errors()]
        raise SettingsError("the command line", problems) from error


def _problem(detail: Any) -> str:
    key = ".".join(str(step) for step in detail["loc"]) or "settings"
    if detail["type"] == "extra_forbidden":
        table = _TABLES.get(key.partition(".")[0]) if "." in key else None
        model = Settings if table is None else table
        return f"{key}: unknown key; there are {', '.join(model.model_fields)}"
    if detail["type"] == "value_error":  # of all settings together
        return f"{key}: {detail['ctx']['error']}"
    return f"{key}: {detail['msg']}, this is {without_secrets(repr(detail['input']))}"


_TABLES: dict[str, type[BaseModel]] = {
    "station": StationSettings,
    "stations": StationSettings,
    "security": SecuritySettings,
}


def _count_from(folder: Path, values: dict[str, Any]) -> None:
    """Make relative folders and files of the file count from where the file lies."""
    security = values.get("security")
    if isinstance(security, dict):
        for key in ("keys_file", "tls_cert", "tls_key"):
            if isinstance(value := security.get(key), str):
                security[key] = str(folder / value)
    several = values.get("stations")
    for station in (values.get("station"), *(several if isinstance(several, list) else ())):
        if not isinstance(station, dict):
            continue
        for key in ("source", "asset", "calibration"):
            value = station.get(key)
            if isinstance(value, str) and (folder / value).exists():
                station[key] = str(folder / value)
        if isinstance(record := station.get("record"), str) and record:
            # It is made when there is something to record.
            station["record"] = str(folder / record)
