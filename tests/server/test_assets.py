"""Assets over HTTP: what they hold, and meshes that another reader of glTF understands."""

from __future__ import annotations

import asyncio
import hashlib
import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
import trimesh
from harness import Server
from scripted_pipeline import CLASS_IDS, PART_NAMES
from test_api import assert_problem

from snapfit.models.asset import find_asset
from snapfit.models.cache import CACHE_VARIABLE
from snapfit.models.gltf import GLTF_FROM_BODY, glb
from snapfit.models.pose import Pose
from snapfit.server.app import create_app
from snapfit.server.asset_export import export_asset
from snapfit.server.asset_library import ExportedAsset
from snapfit.server.conventions import AXES, Convention
from snapfit.server.problems import ProblemError
from snapfit.server.routes.assets import named_asset
from snapfit.server.schemas_assembly import AssetInfo
from snapfit.server.settings import make_settings

PATH = "/v1/assets/scripted-asset"
FILM_PATH = "/v1/assets/any/media/jaw.mp4"
Film = Callable[[dict[str, str | bytes]], httpx.Response]


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
    base = asset.parts[0]
    link = asset.states[-1].links[0]
    moved = link.model_copy(update={"parent_from_child": Pose.exp([0, 0, 0, 1e-6, 0, 0])})
    others = (
        replace(asset, title="Another"),
        replace(asset, parts=(replace(base, color_rgb=(1, 2, 3)), *asset.parts[1:])),
        replace(asset, parts=(replace(base, mesh=asset.parts[1].mesh), *asset.parts[1:])),
        replace(asset, steps=(step.model_copy(update={"text": "Otherwise"}), *asset.steps[1:])),
        replace(asset, states=(asset.states[-1].model_copy(update={"links": (moved,)}),)),
    )
    (bundle / "jaw film.mp4").write_bytes(b"another film")
    folders = {folder, export_asset(asset), *map(export_asset, others)}
    assert len(folders) == 2 + len(others)
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


@pytest.fixture
def film(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Film:
    """The API, without stations, with an asset that has a film of ten bytes."""
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    (tmp_path / "jaw.mp4").write_bytes(b"0123456789")
    clamp = find_asset("hobby-corner-clamp")
    step = clamp.steps[0].model_copy(update={"media": ("jaw.mp4",)})
    exported = ExportedAsset(export_asset(replace(clamp, directory=tmp_path, steps=(step,))))
    app = create_app(make_settings("the test", {}))
    app.dependency_overrides[named_asset] = lambda: exported
    transport = httpx.ASGITransport(app)

    async def ask(headers: dict[str, str | bytes]) -> httpx.Response:
        async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1") as client:
            return await client.get(FILM_PATH, headers=headers)

    return lambda headers: asyncio.run(ask(headers))


@pytest.mark.parametrize(
    ("wanted", "status", "body"),
    [
        (None, 200, b"0123456789"),
        ("bytes=2-4", 206, b"234"),
        ("bytes=7-", 206, b"789"),
        ("bytes=-2", 206, b"89"),
        ("bytes=4-2", 200, b"0123456789"),
        ("bytes=0-1,4-5", 200, b"0123456789"),
        ("bytes=\xff", 200, b"0123456789"),
        ("lines=1-2", 200, b"0123456789"),
    ],
)
def test_a_film_is_served_whole_or_in_a_range(
    film: Film, wanted: str | None, status: int, body: bytes
) -> None:
    headers = {} if wanted is None else {"Range": wanted.encode("latin-1")}
    answer = film(headers)
    assert (answer.status_code, answer.content) == (status, body)
    assert answer.headers["content-type"] == "video/mp4"


@pytest.mark.parametrize("wanted", ["bytes=10-", "bytes=99-100", "bytes=-0"])
def test_a_range_beyond_the_film_is_a_problem(film: Film, wanted: str) -> None:
    problem = assert_problem(film({"Range": wanted}), 416, FILM_PATH)
    assert problem["bytes"] == 10
