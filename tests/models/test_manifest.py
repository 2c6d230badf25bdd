from pathlib import Path

import numpy as np
import pytest

from snapfit.models.errors import ManifestError
from snapfit.models.manifest import JointType, Table, tables
from snapfit.models.manifest_reader import read_manifest

MANIFEST = """
[asset]
name = "clamp"
title = "A clamp"
licence = "Apache-2.0"
mesh_unit_m = 0.001

[[part]]
name = "base"
mesh = "base.ply"
class_id = 0
color_rgb = [10, 20, 30]

[[part]]
name = "bolt"
mesh = "bolt.ply"
class_id = 1
symmetry = { axis = { direction = [0, 0, 1] } }

[[part]]
name = "knob"
mesh = "knob.ply"
class_id = 2
tracked = false
symmetry = { motions = [[[-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]] }

[[state]]
name = "apart"

[[state]]
name = "bolted"

[[state.link]]
parent = "base"
child = "bolt"
parent_from_child = { position_m = [0, 0, 0.05], orientation = [0, 0, 1, 0] }
joint = { type = "screw", axis = [0, 0, 1], pitch_m = 0.0015, travel_m = [0, 0.03] }
translation_tolerance_m = 0.02

[[state.link]]
parent = "bolt"
child = "knob"
parent_from_child = [[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
decides_switch = false

[[step]]
name = "drive-bolt"
title = "Drive the bolt"
text = "Turn it clockwise."
from_state = "apart"
to_state = "bolted"
parts = ["base", "bolt"]
ghost = { part = "bolt", parent = "base", parent_from_part = { position_m = [0, 0, 0.05] } }
annotation = [{ part = "base", anchor_m = [0, 0, 0.01], text = "here" }]
expected_duration_s = 20
"""


def read(directory: Path, text: str = MANIFEST) -> object:
    (directory / "asset.toml").write_text(text)
    return read_manifest(directory)


def test_a_manifest_is_read_whole(tmp_path: Path) -> None:
    (tmp_path / "asset.toml").write_text(MANIFEST)
    manifest = read_manifest(tmp_path)
    assert manifest.asset.mesh_unit_m == 0.001
    assert [part.name for part in manifest.part] == ["base", "bolt", "knob"]
    assert manifest.part[0].color_rgb == (10, 20, 30)
    assert [part.tracked for part in manifest.part] == [True, True, False]
    assert manifest.part[1].symmetry.axis is not None
    assert len(manifest.part[2].symmetry.motions) == 1
    screw, fixed = manifest.state[1].links
    assert screw.joint.type is JointType.SCREW
    assert screw.joint.travel_m == (0, 0.03)
    assert (screw.translation_tolerance_m, screw.rotation_tolerance_deg) == (0.02, 10.0)
    np.testing.assert_allclose(screw.parent_from_child.translation, (0, 0, 0.05))
    np.testing.assert_allclose(screw.parent_from_child.quaternion, (0, 0, 1, 0), atol=1e-12)
    assert fixed.joint.type is JointType.FIXED
    assert not fixed.decides_switch
    np.testing.assert_allclose(fixed.parent_from_child.translation, (0.1, 0, 0))
    step = manifest.step[0]
    assert step.ghost is not None
    assert step.annotation[0].anchor_m == (0, 0, 0.01)
    assert step.expected_duration_s == 20


STEP_BACK = """
[[step]]
name = "back"
title = "Back"
text = "Back"
from_state = "bolted"
to_state = "apart"
parts = ["bolt"]
"""


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('title = "A clamp"', 'titel = "A"', r"asset\.titel: unknown key: did you mean 'title'"),
        ("mesh_unit_m = 0.001", "", r"asset\.mesh_unit_m: is missing: add it"),
        ("mesh_unit_m = 0.001", "mesh_unit_m = 0", r"asset\.mesh_unit_m: .*greater than 0"),
        ("mesh_unit_m = 0.001", "mesh_unit_m = nan", r"asset\.mesh_unit_m: .*finite"),
        ("mesh_unit_m = 0.001", "mesh_unit_m = 1000", r"asset\.mesh_unit_m: .*less than or equal"),
        ("mesh_unit_m = 0.001", "mesh_unit_m = ", r"is not valid TOML: .*line 6"),
        ('name = "knob"', 'name = "bolt"', r"part\[2\]\.name: 'bolt' is there twice"),
        ("class_id = 2", "class_id = 1", r"part\[2\]\.class_id: 1 is there twice"),
        ("[10, 20, 30]", "[10, 20, 300]", r"part\[0\]\.color_rgb\[2\]: .*255, this is 300"),
        ("direction = [0, 0, 1]", "direction = [0, 0, 0]", r"part\[1\]\.symmetry\.axis: .*length"),
        ("[0, -1, 0, 0]", "[0, 1, 0, 0]", r"part\[2\]\.symmetry\.motions\[0\]: .*mirrored"),
        ('mesh = "base.ply"', 'mesh = "../base.ply"', r"part\[0\]\.mesh: .*outside of the asset"),
        ('parent = "base"', 'parent = "bass"', r"state\[1\]\.link\[0\]\.parent: .*: base, bolt"),
        ('child = "bolt"', 'child = "base"', r"link\[0\]\.child: 'base' is linked to itself"),
        ("orientation = [0, 0, 1, 0]", "orientation = [0, 0, 0, 0]", r"parent_from_child: .*quat"),
        ("position_m = [0, 0, 0.05], o", "position = [0, 0, 0], o", r"parent_from_child: a pose"),
        ("tolerance_m = 0.02", "tolerance_m = 0.0", r"translation_tolerance_m: .*greater than 0"),
        (
            '"screw", axis = [0, 0, 1],',
            '"screw",',
            r"link\[0\]\.joint: a screw joint needs an axis",
        ),
        ("pitch_m = 0.0015,", "", r"link\[0\]\.joint: a screw, .*needs a pitch_m"),
        ("travel_m = [0, 0.03]", "travel_m = [0.03, 0]", r"joint: travel_m is \[least, largest\]"),
        ('type = "screw"', 'type = "hinge"', r"joint\.type: .*'revolute'.*this is 'hinge'"),
        ('to_state = "bolted"', 'to_state = "built"', r"step\[0\]\.to_state: .*apart, bolted"),
        ('from_state = "apart"', 'from_state = "a"', r"step\[0\]\.from_state: there is no state"),
        ('parts = ["base", "bolt"]', 'parts = ["nut"]', r"step\[0\]\.parts\[0\]: .*no part 'nut'"),
        ('{ part = "base", anchor', '{ part = "b", anchor', r"step\[0\]\.annotation\[0\]\.part"),
        ('ghost = { part = "bolt"', 'ghost = { part = "b"', r"step\[0\]\.ghost\.part: there is no"),
        ("expected_duration_s = 20", "expected_duration_s = -1", r"step\[0\]\.expected_duration_s"),
        ("expected_duration_s = 20", 'media = ["a.png"]', r"step\[0\]\.media\[0\]: no such file"),
        ("expected_duration_s = 20", STEP_BACK, "go round in a circle: .*apart.*bolted"),
        (MANIFEST[MANIFEST.index("[[step]]") :], "", r"state\[1\]\.name: no step leads from"),
        ('"knob"\nparent', '"base"\nparent', "stand on each other in a circle"),
        ('child = "knob"', 'child = "bolt"', r"link\[1\]\.child: 'bolt' is linked to itself"),
    ],
)
def test_a_bad_manifest_names_file_key_and_remedy(
    tmp_path: Path, old: str, new: str, problem: str
) -> None:
    assert old in MANIFEST
    with pytest.raises(ManifestError, match=problem) as caught:
        read(tmp_path, MANIFEST.replace(old, new, 1))
    assert str(caught.value).startswith(str(tmp_path / "asset.toml"))
    assert "\n" not in str(caught.value)


def test_a_part_stands_on_one_other(tmp_path: Path) -> None:
    text = MANIFEST.replace('parent = "bolt"\nchild = "knob"', 'parent = "knob"\nchild = "bolt"')
    with pytest.raises(ManifestError, match="'bolt' already stands on 'base' in this state"):
        read(tmp_path, text)


def test_a_folder_without_manifest_is_no_asset(tmp_path: Path) -> None:
    with pytest.raises(ManifestError, match=r"asset\.toml: no such file: an asset is a folder"):
        read_manifest(tmp_path)


def test_a_manifest_is_text(tmp_path: Path) -> None:
    (tmp_path / "asset.toml").write_bytes(b"\xff\xfe[asset]")
    with pytest.raises(ManifestError, match="is not UTF-8"):
        read_manifest(tmp_path)


@pytest.mark.parametrize("table", tables())
def test_every_field_is_described_and_unknown_keys_are_rejected(table: type[Table]) -> None:
    assert table.model_config["extra"] == "forbid"
    for name, field in table.model_fields.items():
        assert field.description, f"{table.__name__}.{name}"
