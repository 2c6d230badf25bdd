"""Assets: the products under assembly, their parts, states and steps."""

from __future__ import annotations

from snapfit.clients.python.assembly import StepInfo
from snapfit.clients.python.schema import Convention, PlacedPose, Schema


class PartInfo(Schema):
    """A part of an asset; `mesh` is the path of its binary glTF."""

    part: str
    class_id: int
    tracked: bool
    color_rgb: tuple[int, int, int]
    symmetric: bool
    diameter_m: float
    mesh: str
    mesh_bytes: int
    mesh_sha256: str


class LinkInfo(PlacedPose):
    """Child stands on parent, at this pose in the parent's frame."""

    parent: str
    child: str
    joint: str


class StateInfo(Schema):
    """A node of the assembly graph."""

    state: str
    title: str
    links: tuple[LinkInfo, ...]


class AssetInfo(Schema):
    """A product: its parts, and how they come together."""

    asset: str
    title: str
    licence: str
    convention: Convention
    parts: tuple[PartInfo, ...]
    states: tuple[StateInfo, ...]
    steps: tuple[StepInfo, ...]


class AssetEntry(Schema):
    """An asset in the list of all, and where it is under assembly."""

    asset: str
    title: str
    stations: tuple[str, ...]


class AssetList(Schema):
    """The assets that the server's stations assemble."""

    assets: tuple[AssetEntry, ...]
