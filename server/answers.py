"""Ready-made answers from the latest snapshot: parsed once, dumped once, served many times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import orjson


@dataclass(frozen=True)
class Answer:
    """One resource at one snapshot; only its age is still to be written.

    Attributes:
        etag: entity tag, weak because the age in the body goes on; covers boot_id, seq, stale.
        captured_at_us: exposure of the frame, Unix time, microseconds.
        start: the JSON up to the age.
    """

    etag: bytes
    captured_at_us: int
    start: bytes

    @staticmethod
    def of(snapshot: dict[str, Any]) -> Answer:
        """The answer for this JSON object, which has no `age_us` yet."""
        flag = "stale" if snapshot["stale"] else "fresh"
        return Answer(
            etag=f'W/"{snapshot["boot_id"]}-{snapshot["seq"]}-{flag}"'.encode(),
            captured_at_us=snapshot["captured_at_us"],
            start=orjson.dumps(snapshot)[:-1] + b',"age_us":',
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
        self._answers: dict[tuple[str | None, bool], Answer] = {}
        self.generation = generation
        self.boot_id: str = self._snapshot["boot_id"]
        self.captured_at_us: int = self._snapshot["captured_at_us"]

    @property
    def part_names(self) -> list[str]:
        """The parts that there are."""
        return [part["part"] for part in self._snapshot["parts"]]

    def all_parts(self, *, stale: bool) -> Answer:
        """A `PoseSnapshot`."""
        answer = self._answers.get((None, stale))
        if answer is None:
            answer = Answer.of({**self._snapshot, "stale": stale})
            self._answers[None, stale] = answer
        return answer

    def one_part(self, name: str, *, stale: bool) -> Answer | None:
        """A `PartSnapshot`; None for a part that does not exist."""
        answer = self._answers.get((name, stale))
        if answer is None:
            header = {**self._snapshot, "stale": stale}
            poses = {part["part"]: part for part in header.pop("parts")}
            if name not in poses:
                return None
            answer = Answer.of({**header, "pose": poses[name]})
            self._answers[name, stale] = answer
        return answer
