import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.errors import MeshError, SequenceError
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.models.sequence import BodyRecord, load_sequence
from snapfit.models.sequence_writer import SequenceWriter

CAMERA = RgbdCamera(
    color=PinholeCamera(64, 48, 60.0, 61.0, 31.5, 23.5),
    depth=PinholeCamera(32, 24, 30.0, 30.5, 15.5, 11.5),
    depth_scale_m=0.0005,
    color_from_depth=Pose.from_translation(0.015, 0, 0),
)
POSE = Pose.exp([0.1, 0.2, 0.3, 0.01, 0.02, 0.5])


def write_sequence(directory: Path, n_frames: int = 3, **options: Any) -> Path:
    """A small sequence of noise with one body, a box."""
    (directory / "meshes").mkdir(parents=True)
    trimesh.creation.box((0.04, 0.05, 0.06)).export(directory / "meshes" / "box.ply")
    bodies = {"box": BodyRecord(mesh="meshes/box.ply")}
    rng = np.random.default_rng(7)
    with SequenceWriter(directory, CAMERA, bodies=bodies, **options) as writer:
        for i in range(n_frames):
            color = rng.integers(0, 256, (48, 64, 3), dtype=np.uint8)
            depth = rng.integers(0, 65536, (24, 32), dtype=np.uint16)
            truth = GroundTruth(f"{i:04d}", {"box": POSE}, {"box": 0.5}, "apart")
            writer.write(f"{i:04d}", color, depth, truth)
    return directory


def edited(directory: Path, edit: Callable[[dict[str, Any]], None]) -> Path:
    """The same sequence with its `sequence.json` changed."""
    path = directory / "sequence.json"
    content = json.loads(path.read_text())
    edit(content)
    path.write_text(json.dumps(content))
    return directory


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    recording = load_sequence(write_sequence(tmp_path / "take", frame_rate_hz=15.0, note="a test"))

    assert recording.name == "take"
    assert recording.frame_rate_hz == 15.0
    assert recording.camera.color == CAMERA.color
    assert recording.camera.depth == CAMERA.depth
    assert recording.camera.depth_scale_m == CAMERA.depth_scale_m
    np.testing.assert_allclose(
        recording.camera.color_from_depth.matrix, CAMERA.color_from_depth.matrix
    )
    assert [frame.name for frame in recording.frames] == ["0000", "0001", "0002"]
    assert [part.name for part in recording.parts] == ["box"]
    assert recording.asset is None
    np.testing.assert_allclose(recording.initial_poses["box"].matrix, POSE.matrix)
    truth = recording.truth["0002"]
    np.testing.assert_allclose(truth.camera_from_body["box"].matrix, POSE.matrix, atol=1e-12)
    assert truth.visibility == {"box": 0.5}
    assert truth.state == "apart"


def test_the_same_frames_make_the_same_bytes(tmp_path: Path) -> None:
    first, second = write_sequence(tmp_path / "a"), write_sequence(tmp_path / "b")
    files = sorted(path.relative_to(first) for path in first.rglob("*") if path.is_file())
    assert len(files) == 9
    for file in files:
        assert (first / file).read_bytes() == (second / file).read_bytes(), file


def test_an_interrupted_writer_leaves_no_sequence(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError), SequenceWriter(tmp_path, CAMERA, asset="x"):
        raise RuntimeError
    with pytest.raises(SequenceError, match=r"sequence\.json: no such file"):
        load_sequence(tmp_path)


def test_the_writer_does_not_overwrite(tmp_path: Path) -> None:
    write_sequence(tmp_path / "take")
    with pytest.raises(SequenceError, match="holds a sequence already"):
        SequenceWriter(tmp_path / "take", CAMERA, asset="x")


@pytest.mark.parametrize(
    ("color", "depth", "problem"),
    [
        (np.zeros((48, 64), np.uint8), np.zeros((24, 32), np.uint16), "colour image"),
        (np.zeros((48, 64, 3), np.uint8), np.zeros((24, 32), np.float32), "depth image"),
        (np.zeros((48, 64, 3), np.uint8), np.zeros((48, 64), np.uint16), "depth image"),
        (np.zeros((48, 64, 3), np.uint8), None, "depth is given with a depth camera"),
    ],
)
def test_the_writer_refuses_what_does_not_fit(
    tmp_path: Path, color: Any, depth: Any, problem: str
) -> None:
    writer = SequenceWriter(tmp_path, CAMERA, asset="x")
    with pytest.raises(SequenceError, match=problem):
        writer.write("0000", color, depth)


def set_key(*path: str | int, value: Any) -> Callable[[dict[str, Any]], None]:
    def edit(content: Any) -> None:
        for key in path[:-1]:
            content = content[key]
        content[path[-1]] = value

    return edit


NAN_POSE = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, float("nan")], [0, 0, 0, 1]]
SCALED_POSE = [[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]]


@pytest.mark.parametrize(
    ("edit", "problem"),
    [
        (set_key("color", "fx", value=0), r"color\.fx: .*greater than 0, this is 0"),
        (set_key("depth", "fy", value=-3.5), r"depth\.fy: .*greater than 0, this is -3\.5"),
        (set_key("color", "cx", value=float("nan")), r"color\.cx: .*finite number, this is nan"),
        (set_key("depth", "fx", value=float("inf")), r"depth\.fx: .*finite number, this is inf"),
        (set_key("depth", "depth_scale", value=0), r"depth\.depth_scale: .*greater than 0"),
        (set_key("depth", "depth2color", value=NAN_POSE), r"depth\.depth2color: .*finite"),
        (set_key("bodies", "box", "initial_pose", value=NAN_POSE), r"bodies\.box\.initial_pose"),
        (set_key("initial_poses", "box", value=NAN_POSE), r"initial_poses\.box: .*finite"),
        (set_key("initial_poses", "box", value=SCALED_POSE), r"initial_poses\.box: .*orthonormal"),
        (set_key("initial_poses", "cup", value=np.eye(4).tolist()), r"initial_poses\.cup: .*: box"),
        (set_key("fps", value=0), r"fps: .*greater than 0"),
        (set_key("frames", value=[]), r"frames: .*at least 1 item"),
        (set_key("frames", value=["../../etc"]), "no plain file name"),
        (set_key("frames", value=["0000", "0000"]), "named twice"),
        (set_key("fsp", value=30), "unknown key 'fsp'"),
        (set_key("bodies", "box", "mesh_unit", value=1), r"bodies\.box: unknown key 'mesh_unit'"),
        (set_key("asset", value="clamp"), "either `bodies` with their meshes, or an `asset`"),
        (lambda content: content.pop("color"), "color: is missing"),
        (lambda content: content["color"].pop("fx"), r"color\.fx: is missing"),
    ],
)
def test_a_broken_sequence_names_file_key_and_remedy(
    tmp_path: Path, edit: Callable[[dict[str, Any]], None], problem: str
) -> None:
    directory = edited(write_sequence(tmp_path / "take"), edit)
    with pytest.raises(SequenceError, match=problem) as caught:
        load_sequence(directory)
    assert str(caught.value).startswith(str(directory / "sequence.json"))
    assert "\n" not in str(caught.value)


def test_remarks_for_people_are_allowed(tmp_path: Path) -> None:
    directory = edited(
        write_sequence(tmp_path / "take"), set_key("bodies", "box", "initial_pose_note", value="!")
    )
    assert load_sequence(directory).parts[0].name == "box"


def test_what_is_no_json_is_refused(tmp_path: Path) -> None:
    (tmp_path / "sequence.json").write_text('{"color": ')
    with pytest.raises(SequenceError, match=r"sequence\.json: is not valid JSON: .*line 1"):
        load_sequence(tmp_path)


def test_a_missing_mesh_is_a_mesh_error(tmp_path: Path) -> None:
    directory = write_sequence(tmp_path / "take")
    (directory / "meshes" / "box.ply").unlink()
    with pytest.raises(MeshError, match=r"box\.ply"):
        load_sequence(directory)


def test_an_unknown_asset_is_named(tmp_path: Path) -> None:
    def use_asset(content: dict[str, Any]) -> None:
        content["bodies"] = {}
        content["asset"] = "no-such-clamp"

    directory = edited(write_sequence(tmp_path / "take"), use_asset)
    with pytest.raises(SequenceError, match=r"asset: no such folder .*'no-such-clamp'"):
        load_sequence(directory)


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("{", "line 4: is not valid JSON"),
        ('{"frame": "0003", "poses": {"box": [[1]]}}', r"line 4: poses\.box"),
        ('{"frame": "0003", "pose": {}}', "line 4: "),
        (
            json.dumps({"frame": "0003", "poses": {"box": NAN_POSE}}),
            r"line 4: poses\.box: .*finite",
        ),
    ],
)
def test_broken_ground_truth_names_its_line(tmp_path: Path, line: str, problem: str) -> None:
    directory = write_sequence(tmp_path / "take")
    with (directory / "gt.jsonl").open("a") as file:
        file.write(line + "\n")
    with pytest.raises(SequenceError, match=problem):
        load_sequence(directory)
