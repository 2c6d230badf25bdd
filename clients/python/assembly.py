"""The assembly: its state, and the steps that lead through it."""

from __future__ import annotations

from enum import StrEnum
from typing import Literal

from snapfit.clients.python.schema import Convention, PlacedPose, Schema, Vector3

DecidedBy = Literal["tracking", "operator"]
MisassemblyKind = Literal["wrong_place", "wrong_way_round", "wrong_part", "wrong_order"]


class MisassemblyInfo(Schema):
    """A part that rests on another one as it should not; how far off, null without a place."""

    part: str
    parent: str
    kind: MisassemblyKind
    translation_m: float | None
    rotation_rad: float | None


class AssemblySummary(Schema):
    """The assembly, as every snapshot carries it; `revision` grows with every change."""

    state: str
    confidence: float
    finished_steps: tuple[str, ...]
    next_steps: tuple[str, ...]
    misassemblies: tuple[MisassemblyInfo, ...]
    decided_by: DecidedBy
    since_us: int
    revision: int


class AssemblyStatus(AssemblySummary):
    """The assembly at the latest snapshot."""

    station: str
    asset: str | None
    boot_id: str
    seq: int
    stale: bool
    captured_at_us: int
    published_at_us: int
    age_us: int


class Ghost(PlacedPose):
    """Where a part belongs: its pose in the frame of `parent`, the part that carries it."""

    part: str
    parent: str


class AnnotationInfo(Schema):
    """A tooltip at a point (metres) in a part's frame."""

    part: str
    anchor: Vector3
    text: str


class StepInfo(Schema):
    """An instruction to a person."""

    step: str
    title: str
    text: str
    from_state: str
    to_state: str
    parts: tuple[str, ...]
    ghost: Ghost | None
    annotations: tuple[AnnotationInfo, ...]
    media: tuple[str, ...]
    expected_duration_s: float | None


class StepProgress(StrEnum):
    """Where a step stands; `next` can be taken now."""

    FINISHED = "finished"
    NEXT = "next"
    LATER = "later"


class StationStep(StepInfo):
    """A step at a station, now; `ghost_in_frame` is null while its parent has no pose."""

    progress: StepProgress
    ghost_in_frame: PlacedPose | None


class StepHeader(Schema):
    """What answers about steps belong to."""

    station: str
    asset: str
    boot_id: str
    seq: int
    stale: bool
    captured_at_us: int
    frame: str
    convention: Convention
    state: str


class StepList(StepHeader):
    """All steps, in the order of the manifest."""

    steps: tuple[StationStep, ...]


class StepAnswer(StepHeader):
    """One step; `alternatives` can be taken now too."""

    step: StationStep
    alternatives: tuple[str, ...]


class CommandResult(Schema):
    """What a command did; `changed` is false where all was so already."""

    station: str
    command: str
    changed: bool
    done: tuple[str, ...]
    state: str | None
