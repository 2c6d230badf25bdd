"""Files: what comes back, in our reader and in others; cut off anywhere, damaged anywhere."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import recordings
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from mcap.reader import make_reader

from snapfit.tracking.errors import FrameError, RecordingError
from snapfit.tracking.recording.reading import OpenRecording
from snapfit.tracking.recording.records import pose_of
from snapfit.tracking.recording.source import McapSource

N_FRAMES = 8


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recordings.write(tmp_path_factory.mktemp("file") / "bench.mcap", N_FRAMES)


def test_what_comes_back_is_what_was_written_bit_for_bit(path: Path) -> None:
    with closing(OpenRecording(path)) as opened:
        assert opened.problem is None
        assert opened.camera.color == recordings.CAMERA.color
        assert opened.camera.depth == recordings.CAMERA.depth
        assert opened.camera.depth_scale_m == recordings.CAMERA.depth_scale_m
        place = recordings.CAMERA.color_from_depth.matrix
        assert opened.camera.color_from_depth.matrix.tobytes() == place.tobytes()
        assert opened.log == ["a line of the log"]
        assert len(opened.results) == N_FRAMES
        for number, each in enumerate(opened.results):
            wanted, shown = recordings.frame(number), opened.frame(each)
            assert (shown.name, shown.captured_at_ns) == (wanted.name, wanted.captured_at_ns)
            assert shown.color.tobytes() == wanted.color.tobytes()
            assert shown.depth is not None
            assert wanted.depth is not None
            assert shown.depth.tobytes() == wanted.depth.tobytes()
            estimate = opened.record(each).parts[0]
            assert estimate.camera_from_body is not None
            pose = pose_of(estimate.camera_from_body)
            assert pose.matrix.tobytes() == recordings.pose(number).matrix.tobytes()
            assert np.array_equal(np.array(estimate.covariance), np.eye(6) / 3)


def test_loose_parts_come_back_whole(path: Path) -> None:
    with closing(McapSource(path)) as source:
        (part,) = source.parts
        wanted = recordings.BOX
        assert (part.name, part.color_rgb, part.class_id) == ("box", (1, 2, 3), 7)
        assert part.mesh.digest == wanted.mesh.digest
        assert part.symmetry.kind == "axis + discrete"
        assert part.symmetry.axis is not None
        assert np.array_equal(part.symmetry.axis.point_m, [0.1, 0, 0])
        first = recordings.LooseSource.initial_poses["box"].matrix
        assert source.initial_poses["box"].matrix.tobytes() == first.tobytes()
        assert source.asset is None


def test_it_plays_as_a_source(path: Path) -> None:
    with closing(McapSource(path, loop="pingpong", start_at_ns=0)) as source:
        names = [frame.name for _ in range(2 * N_FRAMES) if (frame := source.read())]
    forwards = [f"{number:06d}" for number in range(N_FRAMES)]
    assert names == [*forwards, *forwards[-2:0:-1], *forwards[:2]]


def test_other_readers_read_it_by_its_index(path: Path) -> None:
    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == sum(1 for _ in reader.iter_messages())
        topics = {channel.topic for channel in summary.channels.values()}
        assert {"/camera/color", "/camera/depth", "/parts/box/pose", "/tf", "/log"} <= topics
        counts = {topic: sum(1 for _ in reader.iter_messages(topics=[topic])) for topic in topics}
        assert counts["/camera/color"] == counts["/parts/box/pose"] == N_FRAMES
        assert [attachment.name for attachment in reader.iter_attachments()] == ["box.npz"]


def test_the_types_are_foxgloves_and_described_in_the_file(path: Path) -> None:
    kinds = {
        "/camera/color": CompressedImage,
        "/camera/color/calibration": CameraCalibration,
        "/parts/box/pose": PoseInFrame,
    }
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages(topics=list(kinds)):
            assert schema is not None
            kind = kinds[channel.topic]
            assert (schema.name, schema.encoding) == (kind.DESCRIPTOR.full_name, "protobuf")
            pool = DescriptorPool()
            for described in FileDescriptorSet.FromString(schema.data).file:
                pool.Add(described)
            assert "timestamp" in pool.FindMessageTypeByName(schema.name).fields_by_name
            read = kind.FromString(message.data)
            if kind is CompressedImage:
                assert read.format == "png"
                assert read.timestamp.ToNanoseconds() == message.log_time
            elif kind is CameraCalibration:
                assert list(read.K) == recordings.CAMERA.color.matrix.ravel().tolist()
            else:
                number = round((message.log_time - recordings.START_NS) / 40e6)
                wanted = recordings.pose(number)
                at = read.pose.position
                assert [at.x, at.y, at.z] == wanted.translation.tolist()


def test_cut_off_anywhere_all_that_is_whole_is_read(path: Path, tmp_path: Path) -> None:
    data = path.read_bytes()
    cut = tmp_path / "cut.mcap"
    n_before = N_FRAMES
    for length in range(len(data) - 20, 9000, -997):
        cut.write_bytes(data[:length])
        try:
            with closing(OpenRecording(cut)) as opened:
                assert opened.problem is not None
                assert "was not finished" in opened.problem
                n_frames = len(opened.results)
                for each in opened.results:
                    opened.frame(each)
        except RecordingError as error:
            assert "before its first chunk" in str(error)  # noqa: PT017
            n_frames = 0
        assert n_frames <= n_before
        n_before = n_frames
    assert n_before == 0


def test_a_damaged_frame_ends_it_and_is_told(path: Path, tmp_path: Path) -> None:
    with closing(OpenRecording(path)) as opened:
        place = opened.results[5].images
    assert place is not None
    data = bytearray(path.read_bytes())
    data[place.offset + place.length // 2] ^= 0xFF
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data)
    with closing(OpenRecording(damaged)) as opened:
        assert len(opened.results) == N_FRAMES
        with pytest.raises(FrameError, match="damaged"):
            opened.frame(opened.results[5])
        opened.frame(opened.results[6])


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "is no MCAP file"),
        (b"PK\x03\x04 something else", "is no MCAP file"),
        (b"\x89MCAP0\r\n", "holds no frame"),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path: Path, content: bytes, problem: str) -> None:
    other = tmp_path / "other.mcap"
    other.write_bytes(content)
    with pytest.raises(RecordingError, match=problem):
        OpenRecording(other)
    with pytest.raises(RecordingError, match="cannot be read"):
        OpenRecording(tmp_path / "missing.mcap")
