"""Meshes: reading, the sizes that others rely on, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from snapfit.models.errors import MeshError
from snapfit.models.mesh import Mesh, count_open_edges, load_mesh, simplified
from snapfit.models.pose import Pose


def box_file(folder: Path, extents_m: tuple[float, ...] = (0.1, 0.06, 0.04)) -> Path:
    path = folder / "box.ply"
    trimesh.creation.box(extents_m).export(path)
    return path


def as_mesh(surface: trimesh.Trimesh) -> Mesh:
    return Mesh(surface.vertices, surface.faces)


@pytest.mark.parametrize("extension", ["ply", "obj", "stl", "glb"])
def test_every_format_gives_the_same_closed_box(tmp_path: Path, extension: str) -> None:
    path = tmp_path / f"box.{extension}"
    trimesh.creation.box((0.1, 0.06, 0.04)).export(path)
    mesh = load_mesh(path)
    assert (mesh.vertices.shape, mesh.vertices.dtype) == ((8, 3), np.float32)
    assert (mesh.faces.shape, mesh.faces.dtype) == ((12, 3), np.int32)
    assert np.allclose(np.ptp(mesh.vertices, axis=0), (0.1, 0.06, 0.04))
    assert count_open_edges(mesh.faces) == 0


def test_sizes(tmp_path: Path) -> None:
    mesh = load_mesh(box_file(tmp_path), body_from_mesh=Pose.from_translation(0.3, 0, 0))
    half_diagonal = np.linalg.norm((0.1, 0.06, 0.04)) / 2
    assert mesh.diameter_m == pytest.approx(2 * half_diagonal, rel=1e-6)
    assert mesh.radius_m == pytest.approx(half_diagonal, rel=1e-6)
    assert np.allclose(mesh.center_m, (0.3, 0, 0), atol=1e-7)


def test_the_diameter_is_the_largest_distance() -> None:
    points = np.random.default_rng(3).normal(size=(200, 3)).astype(np.float32)
    mesh = Mesh(points, np.zeros((1, 3), dtype=np.int32))
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    assert mesh.diameter_m == pytest.approx(distances.max(), rel=1e-6)


def test_a_flat_mesh_has_a_diameter() -> None:
    square = Mesh(np.array([[0, 0, 0], [3, 0, 0], [3, 4, 0], [0, 4, 0]]), np.array([[0, 1, 2]]))
    assert square.diameter_m == pytest.approx(5.0)


def test_unit_and_frame_of_the_mesh_are_applied_in_this_order(tmp_path: Path) -> None:
    path = box_file(tmp_path, (100, 60, 40))
    body_from_mesh = Pose.exp([0, 0, np.pi / 2, 0, 0, 0])
    moved = Pose.from_translation(0.5, 0, 0) @ body_from_mesh
    mesh = load_mesh(path, unit_m=0.001, body_from_mesh=moved)
    assert np.allclose(np.ptp(mesh.vertices, axis=0), (0.06, 0.1, 0.04), atol=1e-6)
    assert np.allclose(mesh.center_m, (0.5, 0, 0), atol=1e-6)


def test_a_box_inside_out_is_turned(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.1, 0.06, 0.04))
    path = tmp_path / "inverted.ply"
    trimesh.Trimesh(box.vertices, box.faces[:, ::-1], process=False).export(path)
    mesh = load_mesh(path)
    volume = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).volume
    assert volume == pytest.approx(0.1 * 0.06 * 0.04, rel=1e-5)


def test_several_bodies_in_a_file_become_one(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box((0.1, 0.1, 0.1)))
    shifted = trimesh.transformations.translation_matrix((0.3, 0, 0))
    scene.add_geometry(trimesh.creation.box((0.1, 0.1, 0.1)), transform=shifted)
    path = tmp_path / "two.glb"
    scene.export(path)
    mesh = load_mesh(path)
    assert len(mesh.faces) == 24
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(0.4, abs=1e-6)


def test_digests_tell_meshes_apart(tmp_path: Path) -> None:
    one, same = load_mesh(box_file(tmp_path)), load_mesh(box_file(tmp_path))
    other = load_mesh(box_file(tmp_path, (0.1, 0.06, 0.041)))
    assert one.digest == same.digest
    assert one.digest != other.digest


def test_missing(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"gone\.ply: there is no such mesh file"):
        load_mesh(tmp_path / "gone.ply")


def test_no_bytes(tmp_path: Path) -> None:
    path = tmp_path / "empty.ply"
    path.touch()
    with pytest.raises(MeshError, match=r"empty\.ply: the mesh file is empty"):
        load_mesh(path)


def test_no_triangles(tmp_path: Path) -> None:
    path = tmp_path / "points.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    with pytest.raises(MeshError, match=r"points\.obj: .*(empty|no readable mesh)"):
        load_mesh(path)


@pytest.mark.parametrize("extension", ["ply", "obj", "stl", "glb", "txt", "step"])
def test_garbage(tmp_path: Path, extension: str) -> None:
    path = tmp_path / f"garbage.{extension}"
    path.write_bytes(np.random.default_rng(4).bytes(3000))
    with pytest.raises(MeshError, match="garbage"):
        load_mesh(path)


@pytest.mark.parametrize("extension", ["ply", "stl", "glb"])
def test_truncated(tmp_path: Path, extension: str) -> None:
    path = tmp_path / f"cut.{extension}"
    trimesh.creation.icosphere(2, 0.05).export(path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(MeshError, match="cut"):
        load_mesh(path)


def test_not_finite(tmp_path: Path) -> None:
    path = tmp_path / "nan.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n")
    with pytest.raises(MeshError, match="not finite"):
        load_mesh(path, require_closed=False)


def test_a_face_without_its_vertex(tmp_path: Path) -> None:
    path = tmp_path / "astray.off"
    path.write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n")
    with pytest.raises(MeshError, match="astray"):
        load_mesh(path)


def test_not_closed(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.1, 0.06, 0.04))
    path = tmp_path / "open.ply"
    trimesh.Trimesh(box.vertices, box.faces[1:], process=False).export(path)
    with pytest.raises(MeshError, match="not closed: 3 edges"):
        load_mesh(path)
    assert len(load_mesh(path, require_closed=False).faces) == 11


@pytest.mark.parametrize("length_m", [50.0, 0.05e-3])
def test_a_size_that_no_part_has_is_blamed_on_the_unit(tmp_path: Path, length_m: float) -> None:
    path = box_file(tmp_path, (length_m, length_m / 2, length_m / 2))
    with pytest.raises(MeshError, match=rf"{length_m:g} m long.*mesh_unit_m is 1;"):
        load_mesh(path)


def test_the_right_unit_heals_the_size(tmp_path: Path) -> None:
    path = box_file(tmp_path, (50, 25, 25))
    assert load_mesh(path, unit_m=0.001).diameter_m == pytest.approx(0.0612, abs=1e-4)


@pytest.mark.parametrize("unit_m", [0.0, -1.0, float("nan"), float("inf")])
def test_a_unit_must_be_positive(tmp_path: Path, unit_m: float) -> None:
    with pytest.raises(MeshError, match="mesh_unit_m is"):
        load_mesh(box_file(tmp_path), unit_m=unit_m)


def drilled_block() -> Mesh:
    block = trimesh.creation.box((0.14, 0.06, 0.04))
    drill = trimesh.creation.cylinder(radius=0.012, height=0.1, sections=200)
    return as_mesh(trimesh.boolean.difference([block, drill], engine="manifold"))


@pytest.mark.parametrize(
    "mesh", [drilled_block(), as_mesh(trimesh.creation.icosphere(4, 0.08))], ids=["block", "sphere"]
)
@pytest.mark.parametrize("max_faces", [1000, 400])
def test_a_simplified_mesh_keeps_its_shape(mesh: Mesh, max_faces: int) -> None:
    coarse = simplified(mesh, max_faces)
    assert 50 < len(coarse.faces) <= max_faces
    surface = trimesh.Trimesh(coarse.vertices, coarse.faces, process=False)
    _, distances, _ = trimesh.proximity.closest_point(surface, mesh.vertices)
    assert distances.max() < 0.02 * mesh.diameter_m


def test_a_mesh_with_few_faces_stays_as_it_is() -> None:
    mesh = as_mesh(trimesh.creation.box((0.1, 0.1, 0.1)))
    assert simplified(mesh, 12) is mesh


def test_an_open_mesh_can_be_simplified() -> None:
    sphere = trimesh.creation.icosphere(4, 0.08)
    half = Mesh(sphere.vertices, sphere.faces[sphere.triangles_center[:, 2] > 0])
    coarse = simplified(half, 300)
    assert 100 < len(coarse.faces) < 600
    assert np.allclose(np.ptp(coarse.vertices, axis=0), (0.16, 0.16, 0.08), atol=0.01)
