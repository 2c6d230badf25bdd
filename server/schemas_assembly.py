"""What the API answers of an asset and of its assembly: parts, states, steps."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Literal

from pydantic import Field

from snapfit.server.conventions import Convention
from snapfit.server.schemas_base import Confidence, Quaternion, Schema, TimestampUs, Vector3


class MisassemblyInfo(Schema):
    """A part that rests on another one as it should not."""

    part: str = Field(description="The part that is wrong.")
    parent: str = Field(description="What it touches, or is linked to.")
    kind: Literal["wrong_place", "wrong_way_round", "wrong_part", "wrong_order"]
    translation_m: float | None = Field(
        description="How far it is from its own place; null if it has none now."
    )
    rotation_rad: float | None = Field(
        description="How far it is turned against its own place; null if it has none now."
    )


class AssemblySummary(Schema):
    """The assembly, as every snapshot carries it."""

    state: str = Field(description="Name of the assembly state.")
    confidence: Confidence = Field(description="0 to 1, that this state holds.")
    finished_steps: list[str] = Field(description="Steps that were taken, in order.")
    next_steps: list[str] = Field(description="Steps that can be taken now; empty at the end.")
    misassemblies: list[MisassemblyInfo] = Field(description="What sits wrong.")
    decided_by: Literal["tracking", "operator"] = Field(description="Who said that it holds.")
    since_us: TimestampUs = Field(description="Exposure of the first frame in this state.")
    revision: int = Field(
        ge=1, description="Grows when anything here but the confidence changes, in one boot_id."
    )


class AssemblyStatus(AssemblySummary):
    """The assembly at the latest snapshot."""

    station: str
    asset: str | None
    boot_id: str
    seq: int
    stale: bool = Field(description="The worker is down or its snapshot too old.")
    captured_at_us: TimestampUs
    published_at_us: TimestampUs
    age_us: int


class PlacedPose(Schema):
    """A position and an orientation."""

    position: Vector3 = Field(description="x, y, z, metres.")
    orientation: Quaternion = Field(description="Unit quaternion x, y, z, w.")


class Ghost(PlacedPose):
    """Where a part belongs: its pose in the frame of the part that carries it."""

    part: str = Field(description="What is to be put there.")
    parent: str = Field(description="The part in whose frame the pose is.")


class AnnotationInfo(Schema):
    """A tooltip."""

    part: str = Field(description="The part in whose frame the point is.")
    anchor: Vector3 = Field(description="The point, metres, in the part's frame.")
    text: str


class StepInfo(Schema):
    """An instruction to a person: an edge of the assembly graph."""

    step: str = Field(description="Its name.")
    title: str
    text: str
    from_state: str
    to_state: str
    parts: list[str] = Field(description="The parts that it handles.")
    ghost: Ghost | None
    annotations: list[AnnotationInfo]
    media: list[str] = Field(description="Pictures and films: addresses, or paths of this server.")
    expected_duration_s: float | None


class StepProgress(StrEnum):
    """Where a step stands."""

    FINISHED = "finished"
    NEXT = "next"
    LATER = "later"


class StationStep(StepInfo):
    """A step at a station, now."""

    progress: StepProgress = Field(
        description="finished; next: it can be taken now; later: not yet, or on another branch."
    )
    ghost_in_frame: PlacedPose | None = Field(
        description="The ghost in the frame of the answer; null while its parent is not tracked."
    )


class StepHeader(Schema):
    """What answers about steps belong to."""

    station: str
    asset: str
    boot_id: str
    seq: int
    stale: bool
    captured_at_us: TimestampUs
    frame: str = Field(description="The frame of `ghost_in_frame`.")
    convention: Convention
    state: str = Field(description="The assembly state.")


class StepList(StepHeader):
    """All steps, in the order of the manifest."""

    steps: list[StationStep]


class StepAnswer(StepHeader):
    """One step."""

    step: StationStep
    alternatives: list[str] = Field(description="Other steps that can be taken now.")


class PartInfo(Schema):
    """A part of an asset."""

    part: str
    class_id: int = Field(description="Class of the detector; BOP's obj_id.")
    tracked: bool
    color_rgb: Annotated[list[int], Field(min_length=3, max_length=3)]
    symmetric: bool = Field(description="Whether some turn of it cannot be seen.")
    diameter_m: float = Field(description="The largest distance between two of its points.")
    mesh: str = Field(description="Path of its glTF binary.")
    mesh_bytes: int
    mesh_sha256: str


class LinkInfo(PlacedPose):
    """Child stands on parent, at this pose in the parent's frame."""

    parent: str
    child: str
    joint: str = Field(description="fixed, revolute, prismatic, cylindrical or screw.")


class StateInfo(Schema):
    """A node of the assembly graph."""

    state: str
    title: str
    links: list[LinkInfo]


class AssetInfo(Schema):
    """A product: its parts, and how they come together."""

    asset: str
    title: str
    licence: str = Field(description="SPDX identifier of the meshes' licence.")
    convention: Convention
    parts: list[PartInfo]
    states: list[StateInfo] = Field(description="The start first; empty where nothing is linked.")
    steps: list[StepInfo]


class AssetEntry(Schema):
    """An asset in the list of all."""

    asset: str
    title: str
    stations: list[str] = Field(description="Where it is under assembly.")


class AssetList(Schema):
    """The assets that this server's stations assemble."""

    assets: list[AssetEntry]
