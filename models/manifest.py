"""The words of an asset's manifest, `asset.toml`: parts, assembly graph, steps.

Every table is a frozen pydantic model that rejects unknown keys. What one table alone cannot
know (names that must exist elsewhere, cycles) is checked in `manifest_reader`.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    model_validator,
)

from snapfit.models.errors import PoseError
from snapfit.models.pose import Pose

_NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]*$"


def parse_pose(value: object) -> Pose:
    """A pose as files write it: rows of a 4x4 matrix, or {position_m, orientation}.

    Raises:
        ValueError: no rigid motion; pydantic adds the key.
    """
    try:
        match value:
            case Pose():
                return value
            case {"position_m": position, "orientation": orientation, **rest} if not rest:
                return Pose.from_quaternion(orientation, position)
            case {"position_m": position, **rest} if not rest:
                return Pose.from_quaternion([0, 0, 0, 1], position)
            case list() | tuple():
                return Pose.from_matrix(value)
    except (PoseError, TypeError, ValueError) as error:
        raise ValueError(str(error)) from error
    raise ValueError(
        "a pose is a 4x4 matrix by rows, or { position_m = [x, y, z], orientation = [x, y, z, w] }"
    )


PoseField = Annotated[
    Pose, BeforeValidator(parse_pose), PlainSerializer(lambda pose: pose.matrix.tolist())
]
Name = Annotated[str, Field(pattern=_NAME, max_length=64)]
Vector = tuple[float, float, float]
Colour = Annotated[int, Field(ge=0, le=255)]


class Table(BaseModel):
    """What all tables share: frozen, no unknown key, no NaN or infinity."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, arbitrary_types_allowed=True
    )


class AssetTable(Table):
    """`[asset]`: the product as a whole."""

    name: Name = Field(description="Identifier, as in the API.")
    title: str = Field(min_length=1, description="Name shown to people.")
    licence: str = Field(min_length=1, description="SPDX identifier of the meshes' licence.")
    mesh_unit_m: float = Field(
        gt=0, le=1, description="Metres of one unit of the meshes: 1.0, or 0.001 for millimetres."
    )


class AxisTable(Table):
    """A line in the body frame."""

    direction: Vector = Field(description="Direction of the line; any length but zero.")
    point_m: Vector = Field(default=(0, 0, 0), description="A point on the line, metres.")

    @model_validator(mode="after")
    def _has_direction(self) -> AxisTable:
        if max(map(abs, self.direction)) < 1e-9:
            raise ValueError("the direction has no length: give an axis such as [0, 0, 1]")
        return self


class SymmetryTable(Table):
    """`symmetry`: the motions that map the part onto itself; none when empty."""

    motions: tuple[PoseField, ...] = Field(
        default=(),
        description="Discrete motions in the body frame, the identity left out (4x4, metres).",
    )
    axis: AxisTable | None = Field(
        default=None, description="Line about which every turn is the same."
    )


class PartTable(Table):
    """`[[part]]`: a rigid thing with a mesh."""

    name: Name = Field(description="Identifier, as in the API.")
    mesh: str = Field(min_length=1, description="Mesh file, relative to the manifest.")
    color_rgb: tuple[Colour, Colour, Colour] = Field(
        default=(160, 160, 160), description="Colour to draw the part in, 0 to 255 each."
    )
    class_id: int = Field(ge=0, description="Class of the detector; BOP's obj_id.")
    symmetry: SymmetryTable = Field(default=SymmetryTable(), description="Symmetry of the part.")
    body_from_mesh: PoseField = Field(
        default_factory=Pose.identity,
        description="Moves the mesh, already in metres, into the body frame.",
    )
    tracked: bool = Field(
        default=True, description="Whether its pose is tracked (screws may not be)."
    )


class JointType(StrEnum):
    """How a child may move on its parent."""

    FIXED = "fixed"
    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"
    CYLINDRICAL = "cylindrical"
    SCREW = "screw"

    @property
    def turns(self) -> bool:
        """Whether the child turns about the axis."""
        return self in (JointType.REVOLUTE, JointType.CYLINDRICAL, JointType.SCREW)

    @property
    def slides(self) -> bool:
        """Whether the child moves along the axis."""
        return self in (JointType.PRISMATIC, JointType.CYLINDRICAL, JointType.SCREW)


class Joint(Table):
    """The motion that a link leaves free; at zero the child stands at `parent_from_child`."""

    type: JointType = Field(default=JointType.FIXED, description="Kind of joint.")
    axis: Vector | None = Field(default=None, description="Direction of the joint, child's frame.")
    point_m: Vector = Field(
        default=(0, 0, 0), description="A point on the axis, child's frame, metres."
    )
    travel_m: tuple[float, float] | None = Field(
        default=None, description="Least and largest travel along the axis, metres; free if absent."
    )
    turn_deg: tuple[float, float] | None = Field(
        default=None, description="Least and largest turn about the axis, degrees; free if absent."
    )
    pitch_m: float | None = Field(
        default=None, gt=-1, lt=1, description="Screw: metres along the axis for a whole turn."
    )

    @model_validator(mode="after")
    def _fits_its_type(self) -> Joint:
        if self.type is JointType.FIXED and self.axis is not None:
            raise ValueError("a fixed joint has no axis: remove it, or set the type")
        if self.type is not JointType.FIXED and (self.axis is None or not any(self.axis)):
            raise ValueError(f"a {self.type} joint needs an axis such as [0, 0, 1]")
        if (self.type is JointType.SCREW) != bool(self.pitch_m):
            raise ValueError("a screw, and no other joint, needs a pitch_m that is not zero")
        self._check_limits("travel_m", self.travel_m, self.type.slides)
        self._check_limits("turn_deg", self.turn_deg, self.type.turns)
        return self

    def _check_limits(self, key: str, limits: tuple[float, float] | None, free: bool) -> None:
        if limits is None:
            return
        if not free:
            raise ValueError(f"a {self.type} joint has no {key}: remove it")
        if limits[0] >= limits[1]:
            raise ValueError(f"{key} is [least, largest], this is {list(limits)}")


class Link(Table):
    """`[[state.link]]`: child stands on parent."""

    parent: Name = Field(description="Part that carries.")
    child: Name = Field(description="Part that is carried.")
    parent_from_child: PoseField = Field(description="Pose of the child in the parent's frame.")
    joint: Joint = Field(default=Joint(), description="Motion left free; fixed if absent.")
    translation_tolerance_m: float = Field(
        default=0.03, gt=0, le=1, description="The step counts as done below this, metres."
    )
    rotation_tolerance_deg: float = Field(
        default=10.0, gt=0, le=180, description="The step counts as done below this, degrees."
    )
    decides_switch: bool = Field(
        default=True, description="Whether the state is judged by this link (not by screws, say)."
    )


class State(Table):
    """`[[state]]`: a node of the assembly graph. The first one is the start."""

    name: Name = Field(description="Identifier, as in the API.")
    title: str = Field(default="", description="Name shown to people.")
    link: tuple[Link, ...] = Field(default=(), description="Links that exist in this state.")

    @property
    def links(self) -> tuple[Link, ...]:
        """Links that exist in this state."""
        return self.link


class Annotation(Table):
    """A tooltip at a point of a part."""

    part: Name = Field(description="Part in whose frame the point is given.")
    anchor_m: Vector = Field(description="The point, metres, body frame.")
    text: str = Field(min_length=1, description="Text to show.")


class Ghost(Table):
    """Where a part belongs, drawn as a ghost on another one."""

    part: Name = Field(description="Part that is to be put there.")
    parent: Name = Field(description="Part on which it is put.")
    parent_from_part: PoseField = Field(description="Target pose in the parent's frame.")


class Step(Table):
    """`[[step]]`: an edge of the assembly graph, one instruction to a person."""

    name: Name = Field(description="Identifier, as in the API.")
    title: str = Field(min_length=1, description="Headline of the instruction.")
    text: str = Field(min_length=1, description="The instruction.")
    from_state: Name = Field(description="State in which the step can be taken.")
    to_state: Name = Field(description="State that the step leads to.")
    parts: tuple[Name, ...] = Field(min_length=1, description="Parts that the step handles.")
    ghost: Ghost | None = Field(default=None, description="Target pose to draw.")
    annotation: tuple[Annotation, ...] = Field(default=(), description="Tooltips.")
    media: tuple[str, ...] = Field(
        default=(), description="Pictures and films: files or addresses."
    )
    expected_duration_s: float | None = Field(
        default=None, gt=0, le=86400, description="How long the step takes, seconds."
    )


class Manifest(Table):
    """A whole `asset.toml`."""

    asset: AssetTable = Field(description="The product as a whole.")
    part: tuple[PartTable, ...] = Field(min_length=1, max_length=64, description="Its parts.")
    state: tuple[State, ...] = Field(
        default=(), description="Assembly states; the first is the start."
    )
    step: tuple[Step, ...] = Field(default=(), description="Steps from one state to the next.")


def tables() -> tuple[type[Any], ...]:
    """Every table that a manifest may hold."""
    return (
        *(Manifest, AssetTable, PartTable, SymmetryTable, AxisTable),
        *(State, Link, Joint, Step, Annotation, Ghost),
    )
