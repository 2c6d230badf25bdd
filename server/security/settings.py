"""The settings of the table `[security]`."""

from __future__ import annotations

import ipaddress
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator
from pydantic_settings import NoDecode

_ORIGIN = r"^(\*|https?://[^/\s]+)$"

Origin = Annotated[str, Field(pattern=_ORIGIN)]
HostName = Annotated[str, Field(min_length=1, max_length=253)]


class SecuritySettings(BaseModel):
    """Who may ask, how much, and from where."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    keys: Literal["auto", "on", "off"] = Field(
        default="auto",
        description="Whether an API key is needed: 'auto' is off where only this machine can ask "
        "(a loopback address) and on everywhere else.",
    )
    keys_file: str | None = Field(
        default=None,
        min_length=1,
        description="File with the hashes of the keys (from the settings file's folder); without "
        "it keys.json in the user's configuration folder.",
    )
    tls_cert: str | None = Field(
        default=None,
        min_length=1,
        description="PEM file with the certificate chain (from the settings file's folder); with "
        "it and tls_key the server speaks HTTPS.",
    )
    tls_key: str | None = Field(
        default=None,
        min_length=1,
        description="PEM file with the certificate's private key, not encrypted.",
    )
    cors_origins: Annotated[tuple[Origin, ...], NoDecode] = Field(
        default=(),
        description="Web origins whose pages may ask from a browser, as https://host:port; '*' "
        "for all.",
    )
    hosts: Annotated[tuple[HostName, ...], NoDecode] = Field(
        default=(),
        description="Further names that this server is asked by while no keys are needed; numbers, "
        "localhost, names without a dot and .local names always work.",
    )
    request_bytes: int = Field(
        default=1_048_576,
        ge=1024,
        le=1_073_741_824,
        description="The longest request body that is read, bytes.",
    )
    requests_per_s: float = Field(
        default=4000,
        gt=0,
        le=1_000_000,
        description="Requests that one key, or one address without a key, may send each second.",
    )
    burst: int = Field(
        default=8000,
        ge=1,
        le=10_000_000,
        description="Requests that it may send at once before that rate counts.",
    )

    @field_validator("cors_origins", "hosts", mode="before")
    @classmethod
    def _split(cls, value: Any) -> Any:
        """In the environment the names stand in one line, with commas."""
        if isinstance(value, str):
            return [name.strip() for name in value.split(",") if name.strip()]
        return value


def keys_needed(security: SecuritySettings, host: str) -> bool:
    """Whether a server at this address asks for keys."""
    if security.keys != "auto":
        return security.keys == "on"
    return not is_loopback(host)


def is_loopback(host: str) -> bool:
    """Whether only this machine can ask a server that listens at this address."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
