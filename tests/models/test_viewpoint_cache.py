"""Viewpoint models on disk: hits, damage, several processes, no place to write."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from snapfit.models import viewpoint_build, viewpoint_cache
from snapfit.models.cache import cache_directory
from snapfit.models.mesh import Mesh
from snapfit.models.viewpoint_cache import load_viewpoint_model
from snapfit.models.viewpoint_model import ViewpointModel

ARRAYS = (
    "center_m",
    "directions",
    "neighbours",
    "contour",
    "surface",
    "contour_length_m",
    "surface_area_m2",
)


def box_mesh() -> Mesh:
    box = trimesh.creation.box((0.1, 0.06, 0.04))
    return Mesh(box.vertices, box.faces)


def load(cache: Path) -> ViewpointModel:
    return load_viewpoint_model(box_mesh(), cache=cache, n_divisions=1)


def equal(a: ViewpointModel, b: ViewpointModel) -> bool:
    same_numbers = (a.radius_m, a.unit_m) == (b.radius_m, b.unit_m)
    return same_numbers and all(np.array_equal(getattr(a, n), getattr(b, n)) for n in ARRAYS)


def only_file(cache: Path) -> Path:
    (path,) = cache.iterdir()
    return path


@pytest.fixture
def builds(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Grows by one with each model that is generated."""
    calls: list[int] = []
    build = viewpoint_build.build_viewpoint_model

    def counted(*args: object, **kwargs: object) -> ViewpointModel:
        calls.append(1)
        return build(*args, **kwargs)  # type: ignore[arg-type]

    monkeypatch.setattr(viewpoint_build, "build_viewpoint_model", counted)
    return calls


def test_a_hit_equals_what_was_generated(tmp_path: Path, builds: list[int]) -> None:
    generated = viewpoint_build.build_viewpoint_model(box_mesh(), n_divisions=1)
    first, second = load(tmp_path), load(tmp_path)
    assert len(builds) == 2
    assert equal(first, generated)
    assert equal(second, generated)


def test_arrays_are_read_only_and_mapped(tmp_path: Path) -> None:
    for model in (load(tmp_path), load(tmp_path)):
        assert type(model.contour) is np.ndarray
        assert model.contour.flags.c_contiguous
        assert not model.contour.flags.writeable
        base = model.contour
        while isinstance(base.base, np.ndarray):
            base = base.base
        assert isinstance(base, np.memmap)


def test_progress_ends_at_one_for_a_hit_too(tmp_path: Path) -> None:
    for _ in range(2):
        shares: list[float] = []
        load_viewpoint_model(box_mesh(), shares.append, cache=tmp_path, n_divisions=1)
        assert shares[-1] == 1.0


def test_another_mesh_or_grid_is_another_model(tmp_path: Path, builds: list[int]) -> None:
    load(tmp_path)
    taller = box_mesh()
    taller.vertices[:, 2] *= 1.1
    load_viewpoint_model(taller, cache=tmp_path, n_divisions=1)
    load_viewpoint_model(box_mesh(), cache=tmp_path, n_divisions=0)
    assert len(builds) == len(list(tmp_path.iterdir())) == 3


def test_other_code_makes_another_model(
    tmp_path: Path, builds: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    load(tmp_path)
    monkeypatch.setattr(viewpoint_cache, "_code_digest", lambda: "0" * 64)
    load(tmp_path)
    assert len(builds) == 2


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: data[:0],
        lambda data: data[: len(data) // 2],
        lambda data: data[:40],
        lambda data: b"\n" + data,
        lambda data: b"{}\n" + data,
        lambda data: b"[1]\n" + data,
        lambda data: data[:-5000] + bytes([data[-5000] ^ 1]) + data[-4999:],
        lambda data: data[::-1],
        lambda data: data.replace(b"contour_length_m", b"contour_length_x"),
    ],
    ids=["empty", "half", "head", "line", "no keys", "list", "bit", "reversed", "name"],
)
def test_a_damaged_file_is_made_anew(
    tmp_path: Path, builds: list[int], damage: object, caplog: pytest.LogCaptureFixture
) -> None:
    good = load(tmp_path)
    path = only_file(tmp_path)
    data = path.read_bytes()
    path.write_bytes(damage(data))  # type: ignore[operator]
    again = load(tmp_path)
    assert len(builds) == 2
    assert f"{path} is damaged" in caplog.text
    assert equal(again, viewpoint_build.build_viewpoint_model(box_mesh(), n_divisions=1))
    assert only_file(tmp_path).read_bytes() == data
    assert good.n_views == again.n_views


PROCESS = """
import hashlib, sys, trimesh
from pathlib import Path
from snapfit.models.mesh import Mesh
from snapfit.models.viewpoint_cache import load_viewpoint_model
box = trimesh.creation.box((0.1, 0.06, 0.04))
sys.stdout.write("ready\\n"), sys.stdout.flush(), sys.stdin.readline()
model = load_viewpoint_model(Mesh(box.vertices, box.faces), cache=Path(sys.argv[1]), n_divisions=2)
sys.stdout.write(hashlib.sha256(model.contour.tobytes()).hexdigest())
"""


def test_two_processes_at_once(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", PROCESS, str(cache)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    for process in processes:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("go\n")
        process.stdin.flush()
    digests = [process.communicate(timeout=300)[0] for process in processes]
    assert [process.returncode for process in processes] == [0, 0]
    assert len(digests[0]) == 64
    assert digests[0] == digests[1]
    assert only_file(cache).suffix == ".viewpoints"


def test_without_a_place_to_write_the_model_stays_in_memory(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    occupied = tmp_path / "file"
    occupied.touch()
    model = load(occupied / "cache")
    assert model.n_views == 42
    assert not model.contour.flags.writeable
    assert "SNAPFIT_CACHE" in caplog.text


def test_a_full_disk_leaves_the_model_and_no_litter(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    assert load(tmp_path).n_views == 42
    assert "No space left" in caplog.text
    assert list(tmp_path.iterdir()) == []


def test_the_oldest_models_are_forgotten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viewpoint_cache, "_FILES_KEPT", 3)
    for age in range(5):
        old = tmp_path / f"{age}.viewpoints"
        old.touch()
        os.utime(old, (1e9 - age, 1e9 - age))
    load(tmp_path)
    left = {path.name for path in tmp_path.iterdir()}
    assert len(left) == 3
    assert {"0.viewpoints", "1.viewpoints"} < left


def test_the_cache_is_where_the_environment_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SNAPFIT_CACHE", str(tmp_path / "mine"))
    assert cache_directory() == tmp_path / "mine"
    assert cache_directory().is_dir()
    load_viewpoint_model(box_mesh(), n_divisions=0)
    assert only_file(tmp_path / "mine" / "viewpoints").suffix == ".viewpoints"


def test_without_the_variable_the_cache_is_the_users(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("SNAPFIT_CACHE", raising=False)
    monkeypatch.setattr("platformdirs.user_cache_dir", lambda name: str(tmp_path / name))
    assert cache_directory() == tmp_path / "snapfit"
