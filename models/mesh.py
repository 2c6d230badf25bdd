"""Triangle meshes of bodies: reading, checking, simplifying. Metres, body frame."""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.errors import MeshError
from snapfit.models.pose import Pose

LARGEST_EXTENT_M = 5.0
SMALLEST_EXTENT_M = 0.001

# What trimesh's readers are known to raise on files that are damaged or of another format.
_READ_FAILURES = (
    ValueError,
    TypeError,
    KeyError,
    IndexError,
    AttributeError,
    NotImplementedError,
    AssertionError,
    OSError,
    EOFError,
    ImportError,
    struct.error,
)
_ROWS_AT_ONCE = 512
_COARSEST_TOLERANCE = 0.005


@dataclass(frozen=True, eq=False)
class Mesh:
    """The surface of a body.

    Attributes:
        vertices: (V, 3) float32, metres, body frame.
        faces: (F, 3) int32, vertex indices; counter-clockwise from outside where it is closed.
    """

    vertices: npt.NDArray[np.float32]
    faces: npt.NDArray[np.int32]

    def __post_init__(self) -> None:
        # Plain, contiguous and writable: Numba compiles anew for any other kind of array.
        vertices = np.require(self.vertices, np.float32, ["C", "W", "E"])
        faces = np.require(self.faces, np.int32, ["C", "W", "E"])
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces)

    @cached_property
    def hull_points(self) -> npt.NDArray[np.float64]:
        """(N, 3) corners of the convex hull, metres, body frame; all vertices of a flat mesh."""
        return _hull_points(self.vertices.astype(np.float64))

    @cached_property
    def diameter_m(self) -> float:
        """The largest distance between two vertices (as in BOP's `models_info`)."""
        points = self.hull_points
        squared = 0.0
        norms = (points**2).sum(axis=1)
        for start in range(0, len(points), _ROWS_AT_ONCE):
            rows = slice(start, start + _ROWS_AT_ONCE)
            distances = norms[rows, None] + norms[None] - 2 * points[rows] @ points.T
            squared = max(squared, float(distances.max()))
        return float(np.sqrt(squared))

    @cached_property
    def center_m(self) -> npt.NDArray[np.float64]:
        """(3,) centre of the box around the vertices, body frame."""
        vertices = self.vertices.astype(np.float64)
        center: npt.NDArray[np.float64] = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        return center

    @cached_property
    def radius_m(self) -> float:
        """Radius of the sphere around `center_m` that holds every vertex."""
        return float(np.linalg.norm(self.vertices - self.center_m, axis=1).max())

    @cached_property
    def digest(self) -> str:
        """SHA-256 of vertices and faces: two meshes with one digest are the same."""
        sha = hashlib.sha256(f"{self.vertices.shape}{self.faces.shape}".encode())
        sha.update(self.vertices.astype("<f4").tobytes())
        sha.update(self.faces.astype("<i4").tobytes())
        return sha.hexdigest()


def load_mesh(
    path: str | Path,
    unit_m: float = 1.0,
    body_from_mesh: Pose | None = None,
    require_closed: bool = True,
) -> Mesh:
    """Read a mesh (`.glb`, `.ply`, `.obj`, `.stl`) into the body frame.

    Vertices at one place are merged; several bodies in one file become one mesh.

    Args:
        path: the file.
        unit_m: metres of one unit of the file (0.001 for millimetres).
        body_from_mesh: where the mesh, in metres, stands in the body frame; identity if None.
        require_closed: refuse a surface with open edges.

    Raises:
        MeshError: missing, unreadable, empty, not finite, not closed, over 5 m or under 1 mm.
    """
    path = Path(path)
    if not np.isfinite(unit_m) or unit_m <= 0:
        raise MeshError(path, f"mesh_unit_m is {unit_m}: it must be a positive number of metres")
    vertices, faces = _merged(*_read(path))
    if len(faces) == 0:
        raise MeshError(path, "the mesh is empty: it has no triangle; export it again")
    if not np.isfinite(vertices).all():
        raise MeshError(path, "the mesh has vertices that are not finite; export it again")
    vertices = vertices * unit_m
    _check_extent(path, vertices, unit_m)
    n_open = count_open_edges(faces)
    if n_open and require_closed:
        raise MeshError(
            path,
            f"the mesh is not closed: {n_open} edges belong to an odd number of triangles; "
            "close the holes (a mesh repair tool does) and export it again",
        )
    if n_open == 0 and _signed_volume(vertices, faces) < 0:
        faces = faces[:, ::-1]
    if body_from_mesh is not None:
        vertices = body_from_mesh.transform(vertices)
    return Mesh(vertices.astype(np.float32), faces.astype(np.int32))


def simplified(mesh: Mesh, max_faces: int) -> Mesh:
    """A coarser mesh of about `max_faces` triangles; the same mesh if it has no more.

    First merges what is flat to a tolerance that grows to half a percent of the size (Manifold;
    closed meshes only), which keeps the edges of machined parts; then, where that is not enough,
    collapses edges by their quadric error (Garland and Heckbert, 1997; fast-simplification).
    """
    if len(mesh.faces) <= max_faces:
        return mesh
    mesh = _flattened(mesh, max_faces)
    if len(mesh.faces) <= max_faces:
        return mesh
    import fast_simplification

    vertices, faces = fast_simplification.simplify(
        mesh.vertices, mesh.faces, target_count=max_faces
    )
    return Mesh(vertices, faces) if len(faces) else mesh


def count_open_edges(faces: npt.NDArray[Any]) -> int:
    """How many edges belong to an odd number of the faces (F, 3): 0 for a closed surface."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64), axis=1)
    _, counts = np.unique(edges[:, 0] << 32 | edges[:, 1], return_counts=True)
    return int((counts % 2).sum())


def _flattened(mesh: Mesh, max_faces: int) -> Mesh:
    """Fewer triangles by merging what is flat; the same mesh where it is not closed."""
    import manifold3d

    solid = manifold3d.Manifold(manifold3d.Mesh(mesh.vertices, mesh.faces.astype(np.uint32)))
    if solid.status() != manifold3d.Error.NoError:
        return mesh
    tolerance_m, largest_m = 2e-5 * mesh.radius_m, _COARSEST_TOLERANCE * 2 * mesh.radius_m
    while solid.num_tri() > max_faces and tolerance_m <= largest_m:
        solid = solid.simplify(tolerance_m)
        tolerance_m *= 2
    if solid.num_tri() == 0:
        return mesh
    coarse = solid.to_mesh()
    return Mesh(coarse.vert_properties[:, :3], coarse.tri_verts)


def _read(path: Path) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Vertices (V, 3) in the file's unit and faces (F, 3), as they stand in the file."""
    if not path.is_file():
        raise MeshError(path, "there is no such mesh file; check the name in the manifest")
    if path.stat().st_size == 0:
        raise MeshError(path, "the mesh file is empty (0 bytes); export it again")
    import trimesh  # here, because what only knows about meshes must not pay for it

    try:
        loaded = trimesh.load_mesh(path, process=False)
        vertices = np.asarray(loaded.vertices, dtype=np.float64).reshape(-1, 3)
        faces = np.asarray(loaded.faces, dtype=np.int64).reshape(-1, 3)
    except _READ_FAILURES as error:
        raise MeshError(
            path, f"this is no readable mesh ({error}); use .glb, .ply, .obj or .stl"
        ) from error
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise MeshError(path, "a triangle names a vertex that does not exist; export it again")
    return vertices, faces


def _merged(
    vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """One vertex a place (to a millionth of the extent), no triangle that uses a vertex twice."""
    if len(faces) == 0 or not np.isfinite(vertices).all():
        return vertices, faces
    low = vertices.min(axis=0)
    step = max(float((vertices.max(axis=0) - low).max()) * 1e-6, np.finfo(np.float64).tiny)
    keys = np.round((vertices - low) / step).astype(np.int64)
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    merged = inverse.reshape(-1)[faces]
    a, b, c = merged.T
    merged = merged[(a != b) & (b != c) & (c != a)]
    used, compact = np.unique(merged, return_inverse=True)
    return vertices[first[used]], compact.reshape(-1, 3)


def _check_extent(path: Path, vertices: npt.NDArray[np.float64], unit_m: float) -> None:
    extent_m = float(np.ptp(vertices, axis=0).max())
    if SMALLEST_EXTENT_M <= extent_m <= LARGEST_EXTENT_M:
        return
    raise MeshError(
        path,
        f"the part would be {extent_m:.6g} m long (allowed: {SMALLEST_EXTENT_M} to "
        f"{LARGEST_EXTENT_M} m). Wrong unit? mesh_unit_m is {unit_m:g}; "
        "use 0.001 for millimetres, 1 for metres",
    )


def _signed_volume(vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.int64]) -> float:
    """Volume inside a closed surface; negative where its faces are clockwise from outside."""
    a, b, c = (vertices[faces[:, i]] - vertices[0] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def _hull_points(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The points on the convex hull; all of them where the mesh is flat."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        corners: npt.NDArray[np.float64] = points[ConvexHull(points).vertices]
    except QhullError:
        return points
    return corners
