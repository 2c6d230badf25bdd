import itertools
import threading
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.errors import SequenceError
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.models.sequence import BodyRecord
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.tracking.errors import FrameError
from snapfit.tracking.frame import Frame
from snapfit.tracking.sources import Loop, RecordedSource, open_source

CAMERA = RgbdCamera(
    color=PinholeCamera(64, 48, 60.0, 61.0, 31.5, 23.5),
    depth=PinholeCamera(32, 24, 30.0, 30.5, 15.5, 11.5),
)
POSE = Pose.from_translation(0, 0, 0.5)


def images(number: int) -> tuple[Any, Any]:
    """Frame images whose values tell their number."""
    color = np.full((48, 64, 3), 10 * number, np.uint8)
    depth = np.full((24, 32), 500 + number, np.uint16)
    depth[:3], depth[3:6] = 0, 65535
    return color, depth


@pytest.fixture
def directory(tmp_path: Path) -> Path:
    take = tmp_path / "take"
    (take / "meshes").mkdir(parents=True)
    trimesh.creation.box((0.04, 0.05, 0.06)).export(take / "meshes" / "box.ply")
    bodies = {"box": BodyRecord(mesh="meshes/box.ply")}
    with SequenceWriter(
        take, CAMERA, bodies=bodies, frame_rate_hz=25.0, color_format="png"
    ) as writer:
        for i in range(6):
            writer.write(f"{i:02d}", *images(i), GroundTruth(f"{i:02d}", {"box": POSE}))
    return take


def read_all(source: RecordedSource) -> list[Frame | FrameError]:
    frames: list[Frame | FrameError] = []
    while True:
        try:
            frame = source.read()
        except FrameError as error:
            frames.append(error)
            continue
        if frame is None:
            return frames
        frames.append(frame)


def names(frames: list[Frame | FrameError]) -> list[str]:
    return [each.name if isinstance(each, Frame) else f"!{each.frame}" for each in frames]


def test_frames_come_whole_and_in_order(directory: Path) -> None:
    source = RecordedSource(directory, start_at_ns=1_000)
    frames = read_all(source)
    source.close()
    assert names(frames) == ["00", "01", "02", "03", "04", "05"]
    for i, frame in enumerate(frames):
        assert isinstance(frame, Frame)
        color, depth = images(i)
        np.testing.assert_array_equal(frame.color, color)
        assert frame.depth is not None
        np.testing.assert_array_equal(frame.depth, depth)
        assert frame.captured_at_ns == 1_000 + i * 40_000_000
    assert source.initial_poses["box"].translation == pytest.approx((0, 0, 0.5))
    assert list(source.truth) == names(frames)


@pytest.mark.parametrize(
    ("loop", "expected"),
    [
        ("restart", "00 01 02 03 04 05 00 01 02 03 04 05 00"),
        ("pingpong", "00 01 02 03 04 05 04 03 02 01 00 01 02"),
    ],
)
def test_loops_go_on_for_ever_with_rising_times(directory: Path, loop: Loop, expected: str) -> None:
    source = RecordedSource(directory, loop)
    frames = [frame for frame in (source.read() for _ in range(13)) if frame is not None]
    source.close()
    assert [frame.name for frame in frames] == expected.split()
    times = [frame.captured_at_ns for frame in frames]
    assert {later - earlier for earlier, later in itertools.pairwise(times)} == {40_000_000}


def test_closing_ends_the_decoding_thread(directory: Path) -> None:
    before = set(threading.enumerate())
    source = RecordedSource(directory, "restart")
    assert source.read() is not None
    (thread,) = set(threading.enumerate()) - before
    source.close()
    source.close()
    assert not thread.is_alive()
    assert source.read() is None


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-20])


def resize(path: Path) -> None:
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert image is not None
    cv2.imwrite(str(path), image[:-1])


def narrow(path: Path) -> None:
    cv2.imwrite(str(path), np.zeros((24, 32), np.uint8))


def scribble(path: Path) -> None:
    path.write_text("no image at all")


def to_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


@pytest.mark.parametrize(
    ("folder", "damage", "problem"),
    [
        ("color", Path.unlink, r"color/03\.png: no such file"),
        ("depth", Path.unlink, r"depth/03\.png: no such file"),
        ("color", truncate, r"color/03\.png: is truncated after \d+ bytes"),
        ("depth", truncate, r"depth/03\.png: is truncated after \d+ bytes"),
        ("color", resize, r"color/03\.png: is 64x47, but the color intrinsics are for 64x48"),
        ("depth", resize, r"depth/03\.png: is 32x23, but the depth intrinsics are for 32x24"),
        ("depth", narrow, r"depth/03\.png: depth is one channel of uint16, this has 1 of uint8"),
        ("color", scribble, r"color/03\.png: is not a readable image"),
        ("depth", lambda path: path.write_bytes(b""), r"depth/03\.png: is not a readable image"),
        ("color", to_folder, r"color/03\.png: cannot be read"),
    ],
)
def test_a_bad_frame_is_told_and_passed_by(
    directory: Path, folder: str, damage: Any, problem: str
) -> None:
    damage(directory / folder / "03.png")
    source = RecordedSource(directory)
    frames = read_all(source)
    source.close()
    assert names(frames) == ["00", "01", "02", "!03", "04", "05"]
    with pytest.raises(FrameError, match=problem):
        raise frames[3]  # type: ignore[misc]
    assert isinstance(frames[4], Frame)
    assert isinstance(frames[2], Frame)
    assert frames[4].captured_at_ns - frames[2].captured_at_ns == 80_000_000


def test_a_truncated_jpeg_is_told(directory: Path) -> None:
    image = np.random.default_rng(1).integers(0, 256, (48, 64, 3), dtype=np.uint8)
    (directory / "color" / "03.png").unlink()
    path = directory / "color" / "03.jpg"
    cv2.imwrite(str(path), image)
    source = RecordedSource(directory)
    assert names(read_all(source))[3] == "03"
    path.write_bytes(path.read_bytes()[:-200])
    source = RecordedSource(directory)
    assert names(read_all(source))[3] == "!03"


def test_colour_alone_has_no_depth(tmp_path: Path) -> None:
    trimesh.creation.box((0.04, 0.05, 0.06)).export(tmp_path / "box.ply")
    bodies = {"box": BodyRecord(mesh="box.ply")}
    with SequenceWriter(tmp_path, RgbdCamera(CAMERA.color), bodies=bodies) as writer:
        writer.write("0", images(1)[0])
    source = open_source(tmp_path / "sequence.json")
    frame = source.read()
    source.close()
    assert frame is not None
    assert frame.depth is None
    assert source.camera.depth is None
    assert source.initial_poses == {}


def test_what_is_no_recording_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SequenceError, match="no such folder"):
        open_source(tmp_path / "nowhere")
    with pytest.raises(SequenceError, match=r"neither sequence\.json .* nor scene_camera\.json"):
        open_source(tmp_path)


def test_real_frames_open(real_frames: Path) -> None:
    source = open_source(real_frames)
    frame = source.read()
    source.close()
    assert frame is not None
    assert frame.depth is not None
    assert frame.color.shape == (540, 960, 3)
    assert frame.depth.shape == (480, 848)
    assert [part.name for part in source.parts] == ["triangle", "schauma"]
    assert source.initial_poses["triangle"].translation[2] == pytest.approx(0.618302)
