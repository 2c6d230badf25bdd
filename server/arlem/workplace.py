"""An asset as ARLEM's workplace model: parts as things, their points of interest, one sensor.

Names in a manifest hold neither dots nor colons, so ids with a dot cannot be those of parts,
steps or states.
"""

from __future__ import annotations

from collections.abc import Sequence

from snapfit.server.arlem.addresses import Addresses
from snapfit.server.arlem.schemas import (
    Detectable,
    Poi,
    PrimitiveInfo,
    Sensor,
    SensorData,
    Tangible,
    Workplace,
)
from snapfit.server.conventions import AXES, Convention
from snapfit.server.gbot_resource import unity_euler_deg
from snapfit.server.rigid import Rigid
from snapfit.server.schemas_assembly import AssetInfo, PartInfo

BENCH, ORIGIN, ASSEMBLY_SENSOR = "snapfit.bench", "snapfit.origin", "snapfit.assembly"
STATE_KEY = "state"
DEFAULT_POI = "default"
_UNITY = AXES[Convention.UNITY]
_CM_PER_M = 100.0
_UNTURNED = (0.0, 0.0, 0.0, 1.0)


def workplace_of(info: AssetInfo, addresses: Addresses) -> Workplace:
    """The workplace model.

    Args:
        info: the asset in OpenCV's axes.
        addresses: where everything is.
    """
    origin = Detectable(id=ORIGIN, sensor="tracking", type="marker")
    return Workplace(
        id=addresses.workplace,
        name=info.title[:1000],
        origin=ORIGIN,
        things=[_thing(info, part) for part in info.parts],
        places=[Tangible(id=BENCH, name="Bench", detectable=ORIGIN, pois=[_default_poi()])],
        persons=[],
        sensors=[_assembly_sensor(addresses)],
        devices=[],
        apps=[],
        detectables=[origin, *(_detectable(part, addresses) for part in info.parts)],
        primitives=[
            PrimitiveInfo(id=each) for each in ("animation", "image", "video", "audio", "label")
        ],
        predicates=[],
        warnings=[],
    )


def ghost_poi(step: str) -> str:
    """Where a step's part belongs, at the thing that carries it."""
    return f"{step}.ghost"


def note_poi(step: str, number: int) -> str:
    """The anchor of a step's annotation, counted from 1."""
    return f"{step}.note-{number}"


def _thing(info: AssetInfo, part: PartInfo) -> Tangible:
    pois = [_default_poi()]
    for step in info.steps:
        if step.ghost is not None and step.ghost.parent == part.part:
            pois.append(_poi(ghost_poi(step.step), step.ghost.position, step.ghost.orientation))
        for number, each in enumerate(step.annotations, start=1):
            if each.part == part.part:
                pois.append(_poi(note_poi(step.step, number), each.anchor, _UNTURNED))
    return Tangible(id=part.part, name=part.part, detectable=part.part, pois=pois)


def _detectable(part: PartInfo, addresses: Addresses) -> Detectable:
    return Detectable(
        id=part.part,
        sensor="tracking" if part.tracked else None,
        type="marker",
        url=addresses.absolute(part.mesh),
    )


def _assembly_sensor(addresses: Addresses) -> Sensor:
    data = [SensorData(key=STATE_KEY, type="string"), SensorData(key="confidence", type="float")]
    return Sensor(id=ASSEMBLY_SENSOR, url=addresses.assembly, username="", password="", data=data)


def _default_poi() -> Poi:
    return _poi(DEFAULT_POI, (0.0, 0.0, 0.0), _UNTURNED)


def _poi(name: str, position: Sequence[float], orientation: Sequence[float]) -> Poi:
    """A pose in OpenCV's axes, metres, as centimetres and Euler angles in Unity's."""
    placed = Rigid(position, orientation).along(_UNITY)
    x, y, z = (_number(each * _CM_PER_M) for each in placed.position)
    x_deg, y_deg, z_deg = (_number(each, 360) for each in unity_euler_deg(placed.orientation))
    return Poi(
        id=name,
        x_offset=x,
        y_offset=y,
        z_offset=z,
        x_rotation=x_deg,
        y_rotation=y_deg,
        z_rotation=z_deg,
    )


def _number(value: float, turn: int = 0) -> str:
    """With three decimals, no exponent and no minus zero; angles from 0 to below a whole turn."""
    thousandths = round(value * 1000)
    if turn:
        thousandths %= turn * 1000
    sign = "-" if thousandths < 0 else ""
    whole, rest = divmod(abs(thousandths), 1000)
    return f"{sign}{whole}.{rest:03d}".rstrip("0").rstrip(".")
