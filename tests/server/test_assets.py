"""Assets over HTTP: what they hold, and meshes that another reader of glTF understands."""

from __future__ import annotations

import hashlib
import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from harness import Server
from scripted_pipeline import CLASS_IDS, PART_NAMES
from test_api import assert_problem

from snapfit.models.asset import find_asset
from snapfit.models.cache import CACHE_VARIABLE
from snapfit.models.gltf import GLTF_FROM_BODY, glb
from snapfit.server.asset_export import export_asset
from snapfit.server.asset_library import ExportedAsset
from snapfit.server.conventions import AXES, Convention
from snapfit.server.problems import ProblemError
from snapfit.server.schemas_assembly import AssetInfo

PATH = "/v1/assets/scripted-asset"


def test_the_assets_of_all_stations_are_listed(server: Server) -> None:
    listed = server.get("/v1/assets").json()["assets"]
    assert listed == [{"asset": "scripted-asset", "title": "Scripted", "stations": ["bench-1"]}]


def test_an_asset_tells_its_parts_states_and_steps(server: Server) -> None:
    info = AssetInfo.model_validate_json(server.get(PATH).content)
    assert {part.part: part.class_id for part in info.parts} == CLASS_IDS
    assert [state.state for state in info.states] == ["free", "jaw-mounted", "assembled"]
    assert [link.child for link in info.states[2].links] == ["jaw", "bolt"]
    assert [step.step for step in info.steps] == ["mount-jaw", "screw-bolt"]


def test_an_asset_is_given_in_other_conventions(server: Server) -> None:
    link = server.get(f"{PATH}?convention=ros").json()["states"][1]["links"][0]
    np.testing.assert_allclose(link["position"], [0.03, -0.01, -0.02])


def test_a_mesh_is_binary_gltf_and_is_not_sent_twice(server: Server) -> None:
    part = server.get(PATH).json()["parts"][1]
    answer = server.get(part["mesh"])
    assert answer.headers["content-type"] == "model/gltf-binary"
    assert hashlib.sha256(answer.content).hexdigest() == part["mesh_sha256"]
    assert len(answer.content) == part["mesh_bytes"]
    again = server.get(part["mesh"], headers={"If-None-Match": answer.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    mesh = trimesh.load(io.BytesIO(answer.content), file_type="glb", force="mesh")
    wanted = np.array([[0, 0, 0], [0.1, 0, 0], [0, -0.1, 0]])
    assert {tuple(v) for v in np.round(mesh.vertices, 6)} == {tuple(v) for v in wanted}


@pytest.mark.parametrize(
    ("path", "known"),
    [
        ("/v1/assets/another", {"assets": ["scripted-asset"]}),
        (f"{PATH}/parts/jew.glb", {"parts": list(PART_NAMES)}),
        (f"{PATH}/media/jaw.mp4", {}),
        (f"{PATH}/media/..%2F..%2Fasset.json", {}),
    ],
)
def test_what_is_not_there_is_a_problem(server: Server, path: str, known: dict[str, Any]) -> None:
    answer = server.get(path)
    assert answer.status_code == 404
    assert known.items() <= answer.json().items()
    assert answer.json()["type"].startswith("urn:snapfit:problem:unknown-")


def test_a_wrong_convention_is_refused(server: Server) -> None:
    assert_problem(server.get(f"{PATH}?convention=z-up"), 422, PATH)


def test_glb_is_the_mesh_in_gltf_axes() -> None:
    part = find_asset("hobby-corner-clamp").parts[0]
    content = glb(part.name, part.mesh, part.color_rgb)
    mesh = trimesh.load(io.BytesIO(content), file_type="glb", force="mesh", merge_primitives=True)
    mesh.merge_vertices(merge_norm=True)
    assert mesh.is_watertight
    body = trimesh.Trimesh(part.mesh.vertices @ GLTF_FROM_BODY.T, part.mesh.faces)
    np.testing.assert_allclose(mesh.bounds, body.bounds, atol=1e-7)
    assert mesh.volume == pytest.approx(body.volume, rel=1e-5)  # not inside out
    assert (np.array(AXES[Convention.OPENXR].matrix) == GLTF_FROM_BODY).all()
    scene = trimesh.load(io.BytesIO(content), file_type="glb")
    assert list(scene.graph.nodes_geometry) == ["base"]


def test_an_export_is_made_once_and_anew_when_something_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    bundle = tmp_path / "bundle"
    bundle.mkdir()
    (bundle / "jaw film.mp4").write_bytes(b"film")
    clamp = find_asset("hobby-corner-clamp")
    step = clamp.steps[0].model_copy(update={"media": ("jaw film.mp4", "https://example.com/x")})
    asset = replace(clamp, directory=bundle, steps=(step, *clamp.steps[1:]))
    folder = export_asset(asset)
    made_ns = (folder / "asset.json").stat().st_mtime_ns
    assert export_asset(asset) == folder
    assert (folder / "asset.json").stat().st_mtime_ns == made_ns
    exported = ExportedAsset(folder)
    local, address = exported.info.steps[0].media
    assert local == "/v1/assets/hobby-corner-clamp/media/jaw%20film.mp4"
    assert address == "https://example.com/x"
    assert exported.media("jaw film.mp4").read_bytes() == b"film"
    (bundle / "jaw film.mp4").write_bytes(b"another film")
    assert export_asset(asset) != folder
    assert not list((tmp_path / "cache" / "assets").glob(".making-*"))


def test_a_deleted_cache_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    exported = ExportedAsset(export_asset(find_asset("hobby-corner-clamp")))
    assert exported.info.title == "Hobby Corner Clamp"
    (exported.folder / "parts" / "jaw.glb").unlink()
    with pytest.raises(ProblemError, match="deleted from the cache"):
        exported.mesh("jaw")
    with pytest.raises(ProblemError, match="deleted from the cache"):
        _ = ExportedAsset(tmp_path / "nowhere").info
