from pathlib import Path

import pytest
import trimesh

from snapfit.models.asset import find_asset, load_asset
from snapfit.models.errors import ManifestError, MeshError

MANIFEST = """
[asset]
name = "pair"
title = "Two boxes"
licence = "Apache-2.0"
mesh_unit_m = 0.001

[[part]]
name = "lower"
mesh = "lower.ply"
class_id = 0
body_from_mesh = { position_m = [0, 0, 0.01] }

[[part]]
name = "upper"
mesh = "upper.ply"
class_id = 1
tracked = false
symmetry = { axis = { direction = [0, 0, 3], point_m = [0.01, 0, 0] } }
"""


@pytest.fixture
def bundle(tmp_path: Path) -> Path:
    (tmp_path / "asset.toml").write_text(MANIFEST)
    for name in ("lower", "upper"):
        trimesh.creation.box((40, 50, 20)).export(tmp_path / f"{name}.ply")
    return tmp_path


def open_box(path: Path) -> None:
    mesh = trimesh.creation.box((40, 50, 20))
    trimesh.Trimesh(mesh.vertices, mesh.faces[:-1], process=False).export(path)


def test_an_asset_is_loaded_in_metres(bundle: Path) -> None:
    asset = load_asset(bundle)
    lower, upper = asset.parts
    assert (asset.name, asset.directory) == ("pair", bundle)
    assert lower.mesh.vertices.min(axis=0) == pytest.approx((-0.02, -0.025, 0.0), abs=1e-7)
    assert upper.symmetry.axis is not None
    assert upper.symmetry.axis.direction == pytest.approx((0, 0, 1))
    assert lower.symmetry.is_none
    assert asset.tracked_parts == (lower,)


def test_a_missing_mesh_names_the_key(bundle: Path) -> None:
    (bundle / "upper.ply").unlink()
    with pytest.raises(ManifestError, match=r"asset\.toml: part\[1\]\.mesh: no such file: .*upper"):
        load_asset(bundle)


def test_a_tracked_part_is_closed(bundle: Path) -> None:
    open_box(bundle / "lower.ply")
    with pytest.raises(MeshError, match=r"lower\.ply: .*closed"):
        load_asset(bundle)


def test_a_part_that_is_not_tracked_may_be_open(bundle: Path) -> None:
    open_box(bundle / "upper.ply")
    assert len(load_asset(bundle).parts[1].mesh.faces) == 11


@pytest.mark.parametrize("unit", ["1.0", "0.000001"])
def test_the_wrong_unit_is_told(bundle: Path, unit: str) -> None:
    (bundle / "asset.toml").write_text(MANIFEST.replace("0.001", unit, 1))
    with pytest.raises(MeshError, match="mesh_unit_m"):
        load_asset(bundle)


def test_an_asset_is_found_by_folder(bundle: Path) -> None:
    assert find_asset(bundle).name == "pair"
    assert find_asset(str(bundle)).name == "pair"
    assert find_asset(bundle / "asset.toml").directory == bundle


def test_an_unknown_asset_lists_the_bundled_ones() -> None:
    with pytest.raises(
        ManifestError, match="no-such: no such folder and no bundled asset; bundled"
    ):
        find_asset("no-such")
