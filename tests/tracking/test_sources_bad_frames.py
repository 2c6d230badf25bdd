from pathlib import Path

import cv2
import numpy as np
import pytest

from snapfit.tracking.errors import FrameError
from snapfit.tracking.sources import images
from snapfit.tracking.sources.bad_frames import BadFrames


def test_a_fault_is_told_once_and_counted_each_time() -> None:
    told: list[str] = []
    bad_frames = BadFrames(lambda error: told.append(error.frame))
    for loop in range(3):
        bad_frames.add(FrameError("07", "color/07.png: no such file"))
        bad_frames.add(FrameError(f"{loop}", "depth is missing"))
    assert told == ["07", "0"]
    assert bad_frames.count == 6


def test_what_is_remembered_stays_small() -> None:
    told: list[str] = []
    bad_frames = BadFrames(lambda error: told.append(error.frame))
    for i in range(2000):
        bad_frames.add(FrameError(str(i), f"color/{i}.png: no such file"))
    assert bad_frames.count == 2000
    assert len(told) == 1000


def test_an_image_whose_header_claims_too_many_pixels_is_a_frame_error(tmp_path: Path) -> None:
    encoded, jpeg = cv2.imencode(".jpg", np.zeros((48, 64, 3), dtype=np.uint8))
    assert encoded
    data = bytearray(jpeg.tobytes())
    start = data.index(b"\xff\xc0") + 5  # height and width of the frame header
    data[start : start + 4] = (60000).to_bytes(2, "big") * 2
    path = tmp_path / "huge.jpg"
    path.write_bytes(bytes(data))
    with pytest.raises(FrameError, match="huge"):
        images._decode("0", path, cv2.IMREAD_COLOR)
