import json
from pathlib import Path

import cv2
import pytest
import trimesh
import typer
from typer.testing import CliRunner

from snapfit.server.cli.asset import asset_app

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

[[part]]
name = "upper"
mesh = "upper.ply"
class_id = 7
tracked = false
symmetry = { axis = { direction = [0, 0, 1] } }

[[state]]
name = "apart"

[[state]]
name = "stacked"

[[state.link]]
parent = "lower"
child = "upper"
parent_from_child = { position_m = [0, 0, 0.02] }

[[step]]
name = "stack"
title = "Stack them"
text = "Put the upper box on the lower one."
from_state = "apart"
to_state = "stacked"
parts = ["lower", "upper"]
"""

app = typer.Typer()
app.add_typer(asset_app, name="asset")
runner = CliRunner(env={"COLUMNS": "200"})


@pytest.fixture
def bundle(tmp_path: Path) -> Path:
    (tmp_path / "asset.toml").write_text(MANIFEST)
    trimesh.creation.box((40, 50, 20)).export(tmp_path / "lower.ply")
    box = trimesh.creation.box((30, 30, 20))
    trimesh.Trimesh(box.vertices, box.faces[:-1], process=False).export(tmp_path / "upper.ply")
    return tmp_path


def row(output: str, name: str) -> list[str]:
    """The cells of the first table row that begins with a name."""
    rows = ([cell.strip() for cell in line.split("│")[1:-1]] for line in output.splitlines())
    return next(cells for cells in rows if cells and cells[0] == name)


def test_a_good_bundle_is_shown(bundle: Path) -> None:
    result = runner.invoke(app, ["asset", "check", str(bundle)])
    assert result.exit_code == 0, result.output
    assert "Two boxes (pair), Apache-2.0" in result.output
    assert row(result.output, "lower") == [
        *("lower", "0", "40.0 x 50.0 x 20.0", "12", "yes", "none", "yes"),
    ]
    assert row(result.output, "upper")[4:] == ["no, 3 open edges", "axis", "no"]
    assert row(result.output, "stacked") == [
        *("stacked", "lower <- upper (fixed)", "30 mm, 10 deg", "yes"),
    ]
    assert row(result.output, "stack")[1:] == ["apart", "stacked", "lower, upper", "Stack them"]


def test_the_graph_is_mermaid(bundle: Path) -> None:
    result = runner.invoke(app, ["asset", "check", str(bundle)])
    graph = result.output[result.output.index("graph TD") :].splitlines()
    assert graph == ["graph TD", '    s0["apart"]', '    s1["stacked"]', '    s0 -->|"stack"| s1']


def test_the_bundled_asset_is_fit() -> None:
    result = runner.invoke(app, ["asset", "check", "hobby-corner-clamp"])
    assert result.exit_code == 0, result.output
    assert row(result.output, "jaw")[4] == "yes"


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("class_id = 7", "clas_id = 7", "asset.toml: part[1].clas_id: unknown key"),
        ('"lower.ply"', '"lost.ply"', "asset.toml: part[0].mesh: no such file"),
        ('parent = "lower"', 'parent = "base"', "state[1].link[0].parent: there is no part 'base'"),
        ("mesh_unit_m = 0.001", "mesh_unit_m = 1", "the part would be 50 m long"),
        ("mesh_unit_m = 0.001", "mesh_unit_m = 0.000001", "the part would be 5e-05 m long"),
        ("tracked = false", "tracked = true", "upper.ply: the mesh is not closed"),
        ("[[part]]", "[[part]", "asset.toml: is not valid TOML"),
    ],
)
def test_a_bad_bundle_is_one_line_and_exit_code_1(
    bundle: Path, old: str, new: str, problem: str
) -> None:
    assert old in MANIFEST
    (bundle / "asset.toml").write_text(MANIFEST.replace(old, new, 1))
    result = runner.invoke(app, ["asset", "check", str(bundle)])
    assert result.exit_code == 1
    assert result.stdout == ""
    lines = result.stderr.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith(f"error: {bundle}")
    assert problem in lines[0]


def test_an_empty_mesh_is_told(bundle: Path) -> None:
    (bundle / "lower.ply").write_bytes(b"")
    result = runner.invoke(app, ["asset", "check", str(bundle)])
    assert result.exit_code == 1
    assert "lower.ply: the mesh file is empty" in result.stderr


def test_graph_and_exploded_view_are_drawn(bundle: Path, tmp_path: Path) -> None:
    out = tmp_path / "new" / "pictures"
    result = runner.invoke(app, ["asset", "check", str(bundle), "--out", str(out)])
    assert result.exit_code == 0, result.output
    assert (out / "graph.mmd").read_text().startswith('graph TD\n    s0["apart"]\n')
    picture = cv2.imread(str(out / "exploded.png"))
    assert picture is not None
    assert (picture < 250).any(axis=-1).mean() > 0.05


def test_nothing_is_drawn_unasked(bundle: Path) -> None:
    before = set(bundle.iterdir())
    assert runner.invoke(app, ["asset", "check", str(bundle)]).exit_code == 0
    assert set(bundle.iterdir()) == before


@pytest.mark.parametrize("blocked", ["pictures", "pictures/exploded.png"])
def test_a_folder_that_cannot_be_written_is_told(
    bundle: Path, tmp_path: Path, blocked: str
) -> None:
    """A file where the folder should be; a folder where the file should be."""
    if blocked.endswith(".png"):
        (tmp_path / blocked).mkdir(parents=True)
    else:
        (tmp_path / blocked).write_text("in the way")
    out = tmp_path / "pictures"
    result = runner.invoke(app, ["asset", "check", str(bundle), "--out", str(out)])
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith(f"error: {tmp_path / blocked}: ")
    assert "choose another --out" in line


def test_steps_are_written_as_arlem(bundle: Path, tmp_path: Path) -> None:
    out = tmp_path / "new" / "arlem"
    wanted = ["--out", str(out), "--server", "https://bench:8443/", "--station", "bench-2"]
    result = runner.invoke(app, ["asset", "arlem", str(bundle), *wanted, "--language", "de"])
    assert result.exit_code == 0, result.output
    assert {path.name for path in out.iterdir()} == {"pair-activity.json", "pair-workplace.json"}
    activity, workplace = (
        json.loads((out / f"pair-{name}.json").read_text()) for name in ("activity", "workplace")
    )
    assert (activity["id"], activity["workplace"]) == ("pair-activity.json", workplace["id"])
    assert activity["language"] == "de"
    assert [action["id"] for action in activity["actions"]] == [activity["start"]] == ["stack"]
    (sensor,) = workplace["sensors"]
    assert sensor["url"] == "https://bench:8443/v1/stations/bench-2/assembly"
    urls = [each["url"] for each in workplace["detectables"][1:]]
    assert urls == [
        f"https://bench:8443/v1/assets/pair/parts/{it}.glb" for it in ("lower", "upper")
    ]


@pytest.mark.parametrize(
    ("wanted", "problem"),
    [
        (["--server", "bench:8000"], "--server bench:8000: give an address such as http://"),
        (["--language", "German"], "--language German: give two letters"),
        (["--out", "{blocked}"], "cannot be written (Not a directory): choose another --out"),
    ],
)
def test_what_arlem_cannot_be_written_with_is_told(
    bundle: Path, tmp_path: Path, wanted: list[str], problem: str
) -> None:
    (tmp_path / "file").write_text("in the way")
    wanted = [each.replace("{blocked}", str(tmp_path / "file" / "out")) for each in wanted]
    arguments = ["asset", "arlem", str(bundle), "--out", str(tmp_path / "out"), *wanted]
    result = runner.invoke(app, arguments)
    assert result.exit_code == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith("error: ")
    assert problem in line
    assert not (tmp_path / "out").exists()


def test_an_asset_without_steps_has_no_arlem(bundle: Path, tmp_path: Path) -> None:
    manifest = MANIFEST.partition("[[state]]")[0]
    (bundle / "asset.toml").write_text(manifest)
    result = runner.invoke(app, ["asset", "arlem", str(bundle), "--out", str(tmp_path / "out")])
    assert result.exit_code == 1
    assert "asset pair has no steps" in result.stderr
