"""An asset: a set of parts that make one product, its assembly graph and its steps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snapfit.models.errors import ManifestError
from snapfit.models.manifest import PartTable, State, Step, SymmetryTable
from snapfit.models.manifest_reader import MANIFEST_NAME, read_manifest
from snapfit.models.mesh import Mesh, load_mesh
from snapfit.models.symmetry import NO_SYMMETRY, Symmetry, SymmetryAxis

BUNDLED = Path(__file__).parent / "assets"

# Told apart at a glance, and by people who do not see red and green alike (Okabe and Ito, 2008).
PALETTE_RGB = (
    (0, 158, 115),
    (230, 159, 0),
    (86, 180, 233),
    (213, 94, 0),
    (204, 121, 167),
    (240, 228, 66),
    (0, 114, 178),
    (160, 160, 160),
)


@dataclass(frozen=True, eq=False)
class Part:
    """A rigid thing with a mesh.

    Attributes:
        name: identifier, as in the API.
        mesh: surface in metres, body frame.
        color_rgb: colour to draw it in, 0 to 255 each.
        class_id: class of the detector; BOP's obj_id.
        symmetry: the motions that map it onto itself.
        tracked: whether its pose is tracked.
    """

    name: str
    mesh: Mesh
    color_rgb: tuple[int, int, int] = PALETTE_RGB[0]
    class_id: int = 0
    symmetry: Symmetry = NO_SYMMETRY
    tracked: bool = True


@dataclass(frozen=True, eq=False)
class Asset:
    """A product: its parts, and how they come together.

    Attributes:
        name: identifier, as in the API.
        title: name shown to people.
        licence: SPDX identifier of the meshes' licence.
        directory: the bundle's folder.
        parts: in the order of the manifest.
        states: nodes of the assembly graph, the start first; empty when nothing is assembled.
        steps: edges of the assembly graph.
    """

    name: str
    title: str
    licence: str
    directory: Path
    parts: tuple[Part, ...]
    states: tuple[State, ...] = ()
    steps: tuple[Step, ...] = ()

    @property
    def tracked_parts(self) -> tuple[Part, ...]:
        """The parts whose poses are tracked."""
        return tuple(part for part in self.parts if part.tracked)


def load_asset(directory: Path) -> Asset:
    """Loads a bundle with all its meshes.

    Raises:
        ManifestError: the manifest is refused, or a mesh it names is missing.
        MeshError: a mesh is empty, unreadable, not closed though tracked, or in the wrong unit.
    """
    directory = Path(directory)
    manifest = read_manifest(directory)
    unit_m = manifest.asset.mesh_unit_m
    parts = []
    for i, entry in enumerate(manifest.part):
        if not (directory / entry.mesh).is_file():
            problem = f"no such file: {directory / entry.mesh}"
            raise ManifestError(directory / MANIFEST_NAME, f"part[{i}].mesh", problem)
        parts.append(_load_part(directory, entry, unit_m))
    return Asset(
        name=manifest.asset.name,
        title=manifest.asset.title,
        licence=manifest.asset.licence,
        directory=directory,
        parts=tuple(parts),
        states=manifest.state,
        steps=manifest.step,
    )


def find_asset(name_or_path: str | Path) -> Asset:
    """Loads an asset by the name of a bundled one, or from its folder or manifest.

    Raises:
        ManifestError: neither; lists the bundled ones. Or as `load_asset`.
        MeshError: as `load_asset`.
    """
    path = Path(name_or_path)
    if path.name == MANIFEST_NAME:
        path = path.parent
    if path.is_dir():
        return load_asset(path)
    bundled = BUNDLED / path.name
    if str(name_or_path) == path.name and (bundled / MANIFEST_NAME).is_file():
        return load_asset(bundled)
    names = ", ".join(bundled_names()) or "none"
    raise ManifestError(path, "", f"no such folder and no bundled asset; bundled: {names}")


def bundled_names() -> tuple[str, ...]:
    """Names of the assets that come with snapfit."""
    return tuple(sorted(path.parent.name for path in BUNDLED.glob(f"*/{MANIFEST_NAME}")))


def symmetry_of(table: SymmetryTable) -> Symmetry:
    """The symmetry that a manifest or a sequence states."""
    if table.axis is None:
        return Symmetry(table.motions)
    axis = SymmetryAxis(np.array(table.axis.direction), np.array(table.axis.point_m))
    return Symmetry(table.motions, axis)


def _load_part(directory: Path, entry: PartTable, unit_m: float) -> Part:
    mesh = load_mesh(
        directory / entry.mesh,
        unit_m=unit_m,
        body_from_mesh=entry.body_from_mesh,
        require_closed=entry.tracked,
    )
    return Part(
        name=entry.name,
        mesh=mesh,
        color_rgb=entry.color_rgb,
        class_id=entry.class_id,
        symmetry=symmetry_of(entry.symmetry),
        tracked=entry.tracked,
    )
