"""Addresses of cameras, such as "realsense:012345" or "uvc:0?width=1280&height=720"."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from snapfit.tracking.errors import SourceError

KINDS = {
    "realsense": "Intel RealSense, by its serial number",
    "kinect": "Azure Kinect, by its serial number",
    "orbbec": "Orbbec Femto and other Orbbec cameras, by serial number",
    "oak": "Luxonis OAK-D, by its id or its address in the network",
    "uvc": "any USB camera, by its number or device file; colour alone",
    "rtsp": "a network camera, by its URL; colour alone",
}
"""What kinds of cameras there are, and what stands after the colon."""

_NEED_WHERE = ("uvc", "rtsp")
# A drive of Windows has one letter.
_LOOKS_LIKE_A_KIND = re.compile(r"([a-z][a-z0-9_+-]+):(.*)", re.IGNORECASE | re.DOTALL)


class _Options(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    width: int | None = Field(default=None, gt=0, le=16384)
    height: int | None = Field(default=None, gt=0, le=16384)
    fps: int | None = Field(default=None, gt=0, le=1000)


@dataclass(frozen=True)
class Address:
    """Where a camera is.

    Attributes:
        text: as it was given.
        kind: one of `KINDS`.
        where: which one; empty for the first that is found.
        width, height: size of the colour image that is asked for, px; None: as the camera likes.
        fps: frames a second that are asked for; None likewise.
    """

    text: str
    kind: str
    where: str = ""
    width: int | None = None
    height: int | None = None
    fps: int | None = None


def parse_address(text: str) -> Address | None:
    """What an address says; None for what is a path.

    Raises:
        SourceError: there is no such kind of camera, or an option is wrong.
    """
    if Path(text).exists():
        return None
    if text in KINDS and text not in _NEED_WHERE:
        return Address(text, text)
    match = _LOOKS_LIKE_A_KIND.fullmatch(text)
    if match is None:
        if text in KINDS:
            raise SourceError(f"{text}: say which one after a colon: {KINDS[text]}")
        return None
    kind, rest = match[1].lower(), match[2]
    if kind in ("rtsp", "rtsps") and rest.startswith("//"):
        # Its question mark is the stream's own.
        return Address(text, "rtsp", text)
    if kind not in KINDS:
        known = "; ".join(f"{name}: {told}" for name, told in KINDS.items())
        raise SourceError(
            f"{text}: no such file, and no kind of camera {kind!r}. There are {known}"
        )
    if kind == "rtsp":
        raise SourceError(f"{text}: a network camera's URL begins with rtsp://")
    where, _, query = rest.partition("?")
    if not where and kind in _NEED_WHERE:
        raise SourceError(f"{text}: say which one after the colon: {KINDS[kind]}")
    return Address(text, kind, where, **_options(text, query))


def _options(text: str, query: str) -> dict[str, Any]:
    pairs = parse_qsl(query, keep_blank_values=True)
    if query and len(pairs) != len(query.split("&")):
        raise SourceError(f"{text}: options stand as NAME=NUMBER, with & between them")
    try:
        options = _Options.model_validate(dict(pairs))
    except ValidationError as error:
        detail = error.errors()[0]
        key = ".".join(str(step) for step in detail["loc"])
        known = ", ".join(_Options.model_fields)
        problem = f"{key}: {detail['msg']}; the options are {known}"
        raise SourceError(f"{text}: {problem}") from error
    if (options.width is None) != (options.height is None):
        raise SourceError(f"{text}: give width and height, or neither")
    return options.model_dump()
