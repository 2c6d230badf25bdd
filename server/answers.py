"""Ready-made answers from the latest snapshot: parsed once, dumped once, served many times."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import orjson

from snapfit.server.extrapolation import LIMIT_S, extrapolated
from snapfit.server.view import PLAIN, View

_LIMIT_US = round(LIMIT_S * 1e6)
_ASSEMBLY_HEADER = ("station", "asset", "boot_id", "seq", "captured_at_us", "published_at_us")


@dataclass(frozen=True)
class Answer:
    """One resource at one snapshot; only its age is still to be written.

    Attributes:
        etag: entity tag, weak because the age in the body goes on; covers boot_id, seq, stale,
            the view, and the time that poses are extrapolated to.
        captured_at_us: exposure of the frame, Unix time, microseconds.
        start: the JSON up to the age.
        is_stale: whether it says that it is not to be relied on.
    """

    etag: bytes
    captured_at_us: int
    start: bytes
    is_stale: bool

    @staticmethod
    def of(snapshot: dict[str, Any], tag: str = "") -> Answer:
        """The answer for this JSON object, which has no `age_us` yet."""
        flag = "stale" if snapshot["stale"] else "fresh"
        return Answer(
            etag=f'W/"{snapshot["boot_id"]}-{snapshot["seq"]}-{flag}{tag}"'.encode(),
            captured_at_us=snapshot["captured_at_us"],
            start=orjson.dumps(snapshot)[:-1] + b',"age_us":',
            is_stale=snapshot["stale"],
        )

    def body(self, now_us: int) -> bytes:
        """The JSON, at this time."""
        return b"%b%d}" % (self.start, now_us - self.captured_at_us)

    def matches(self, if_none_match: bytes) -> bool:
        """Whether the client has this one: compares as RFC 9110 section 13.1.2 tells."""
        return self.etag[2:] in if_none_match or if_none_match.strip() == b"*"


class SnapshotAnswers:
    """The answers of one snapshot, each made when it is first asked for.

    Args:
        generation: of the snapshot in the store.
        payload: its JSON.
    """

    def __init__(self, generation: int, payload: bytes) -> None:
        self._snapshot: dict[str, Any] = orjson.loads(payload)
        self._answers: dict[tuple[str | None, bool, str], Answer] = {}
        self._assemblies: dict[bool, Answer] = {}
        self.generation = generation
        self.boot_id: str = self._snapshot["boot_id"]
        self.seq: int = self._snapshot["seq"]
        self.revision: int = (self._snapshot.get("assembly") or {}).get("revision", 0)
        self.captured_at_us: int = self._snapshot["captured_at_us"]

    @property
    def snapshot(self) -> dict[str, Any]:
        """The JSON object; to be read only."""
        return self._snapshot

    @property
    def identity(self) -> dict[str, Any]:
        """Which snapshot it is."""
        return {key: self._snapshot[key] for key in ("boot_id", "seq", "captured_at_us")}

    @property
    def part_names(self) -> list[str]:
        """The parts that there are."""
        return [part["part"] for part in self._snapshot["parts"]]

    def all_parts(self, *, stale: bool, view: View = PLAIN, at_us: int | None = None) -> Answer:
        """A `PoseSnapshot`."""
        answer = self._answers.get((None, stale, view.tag)) if at_us is None else None
        if answer is None:
            header, tag = self._header(stale, view, at_us)
            parts = [self._seen(part, view, at_us) for part in self._snapshot["parts"]]
            answer = Answer.of({**header, "parts": parts}, tag)
            if at_us is None:
                self._answers[None, stale, view.tag] = answer
        return answer

    def one_part(
        self, name: str, *, stale: bool, view: View = PLAIN, at_us: int | None = None
    ) -> Answer | None:
        """A `PartSnapshot`; None for a part that does not exist."""
        answer = self._answers.get((name, stale, view.tag)) if at_us is None else None
        if answer is None:
            part = next((it for it in self._snapshot["parts"] if it["part"] == name), None)
            if part is None:
                return None
            header, tag = self._header(stale, view, at_us)
            del header["parts"]
            header.pop("assembly", None)
            answer = Answer.of({**header, "pose": self._seen(part, view, at_us)}, tag)
            if at_us is None:
                self._answers[name, stale, view.tag] = answer
        return answer

    def assembly(self, *, stale: bool) -> Answer | None:
        """An `AssemblyStatus`; None where nothing follows the assembly.

        Its entity tag covers boot_id, revision, confidence in percent, stale.
        """
        told = self._snapshot.get("assembly")
        if told is None:
            return None
        answer = self._assemblies.get(stale)
        if answer is None:
            header = {key: self._snapshot[key] for key in _ASSEMBLY_HEADER}
            made = Answer.of({**header, "stale": stale, **told})
            flag = "stale" if stale else "fresh"
            percent = round(100 * told["confidence"])
            etag = f'W/"{self.boot_id}-a{told["revision"]}-{percent}-{flag}"'.encode()
            answer = self._assemblies[stale] = replace(made, etag=etag)
        return answer

    def _header(self, stale: bool, view: View, at_us: int | None) -> tuple[dict[str, Any], str]:
        """All but the parts, and what tells the answer from others of this snapshot."""
        header = {
            **self._snapshot,
            "stale": stale,
            "frame": view.frame,
            "convention": view.convention,
        }
        if at_us is None:
            return header, view.tag
        reached_us = self._reached(at_us)
        header["at_us"], header["at_clamped"] = reached_us, reached_us != at_us
        return header, f"{view.tag}-at{at_us}"

    def _seen(self, part: dict[str, Any], view: View, at_us: int | None) -> dict[str, Any]:
        if at_us is not None:
            part = extrapolated(part, (self._reached(at_us) - self.captured_at_us) / 1e6)
        return view.part(part)

    def _reached(self, at_us: int) -> int:
        """The nearest time that poses are extrapolated to."""
        earliest_us, latest_us = self.captured_at_us - _LIMIT_US, self.captured_at_us + _LIMIT_US
        return min(max(at_us, earliest_us), latest_us)
