"""What ARLEM's two documents are made of, as far as an asset has something to say in them.

Names, required members and lengths are those of IEEE 1589-2020, as its editors' validator,
openARLEM/arlem.js, checks them. Numbers are written as strings there.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from snapfit.server.schemas_base import Schema

LONGEST_TITLE, LONGEST_LABEL, LONGEST_DESCRIPTION = 100, 100, 5000

Identifier = Annotated[str, Field(max_length=100)]
Reference = Annotated[str, Field(max_length=2000)]
Number = Annotated[str, Field(pattern=r"^-?([0-9]+\.)?[0-9]+$")]
Primitive = Literal["animation", "image", "video", "audio", "label"]
Nothing = Annotated[list[str], Field(max_length=0, description="Always empty.")]
Viewport = Literal["actions", "reactions", "warnings"]


def _hyphenated(name: str) -> str:
    return name.replace("_", "-")


class Poi(Schema):
    """A point of interest of a thing; Unity's axes (x right, y up, z forward, left-handed)."""

    model_config = ConfigDict(
        extra="forbid", alias_generator=_hyphenated, validate_by_name=True, validate_by_alias=True
    )

    id: Identifier = Field(description="Unique in its thing; `default` is the thing's own origin.")
    x_offset: Number = Field(description="Centimetres.")
    y_offset: Number = Field(description="Centimetres.")
    z_offset: Number = Field(description="Centimetres.")
    x_rotation: Number = Field(description="Degrees; z, x, y is the order.")
    y_rotation: Number = Field(description="Degrees.")
    z_rotation: Number = Field(description="Degrees.")


class Tangible(Schema):
    """A thing or a place."""

    id: Identifier = Field(description="Of a thing: the part's name.")
    name: str = Field(max_length=1000)
    detectable: Identifier
    pois: list[Poi]


class Detectable(Schema):
    """How a tangible is recognised."""

    id: Identifier = Field(description="Of a thing: the part's name.")
    sensor: Literal["tracking", "mapping"] | None = Field(
        default=None, description="Absent where nothing tracks the part."
    )
    type: Literal["marker", "anchor"]
    url: Reference | None = Field(default=None, description="The mesh that is tracked.")


class SensorData(Schema):
    """A member of what a sensor answers."""

    key: Identifier
    type: Literal["string", "float", "integer", "boolean"]


class Sensor(Schema):
    """A source of data: the assembly state of a station."""

    id: Identifier
    url: str = Field(max_length=1000)
    username: str = Field(max_length=100)
    password: str = Field(max_length=100, description="Empty: a key belongs to the player.")
    data: list[SensorData]


class PrimitiveInfo(Schema):
    """A kind of augmentation that the activity uses."""

    id: Primitive


class Workplace(Schema):
    """ARLEM's workplace model: what is there, and how it is recognised."""

    id: Reference = Field(description="Its own address.")
    name: str = Field(max_length=1000)
    origin: Identifier = Field(description="The detectable that marks the world's origin.")
    things: list[Tangible] = Field(description="The parts.")
    places: list[Tangible]
    persons: Nothing
    sensors: list[Sensor]
    devices: Nothing
    apps: Nothing
    detectables: list[Detectable]
    primitives: list[PrimitiveInfo]
    predicates: Nothing
    warnings: Nothing


class Deactivate(Schema):
    """An augmentation or action that ends."""

    target: Identifier = Field(description="The thing or place.")
    type: Literal["primitive", "action"]
    augmentation: Identifier = Field(description="The primitive, or the action.")
    poi: Identifier | None = None
    viewport: Viewport | None = None


class Activate(Deactivate):
    """An augmentation or action that begins."""

    url: Reference | None = Field(default=None, description="Of a model, picture, film or sound.")
    text: str | None = Field(default=None, max_length=LONGEST_LABEL, description="Of a label.")


class Transition(Schema):
    """What happens when an action begins or ends."""

    removeSelf: bool = Field(description="Whether the action is taken away then.")  # noqa: N815
    activates: list[Activate]
    deactivates: list[Deactivate]


class Trigger(Schema):
    """What ends an action."""

    id: Identifier = Field(description="The sensor, or the action that is clicked.")
    mode: Literal["sensor", "click"]
    type: Literal["action"] | None = None
    viewport: Viewport | None = None
    key: Identifier | None = None
    operator: Literal["equal"] | None = None
    value: Identifier | None = None


class Instruction(Schema):
    """What a person is told."""

    title: str = Field(max_length=LONGEST_TITLE)
    description: str = Field(max_length=LONGEST_DESCRIPTION)


class Action(Schema):
    """An action: a step of the assembly."""

    id: Identifier = Field(description="The step's name.")
    viewport: Viewport
    type: Viewport
    location: Identifier
    instruction: Instruction
    enter: Transition
    exit: Transition
    triggers: Annotated[list[Trigger], Field(min_length=1)]


class Activity(Schema):
    """ARLEM's activity model: what is done, step by step."""

    id: Reference = Field(description="Its own address.")
    name: str = Field(max_length=1000)
    description: str = Field(max_length=10000)
    language: str = Field(pattern="^[a-z]{2}$", description="ISO 639-1.")
    workplace: Reference = Field(description="The workplace's id, which is its address.")
    start: Identifier = Field(description="The first action.")
    actions: list[Action]
