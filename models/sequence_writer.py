"""Writes a recorded sequence, exactly as `load_sequence` reads it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Literal, Self

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import RgbdCamera
from snapfit.models.errors import SequenceError
from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth
from snapfit.models.sequence import (
    SEQUENCE_NAME,
    BodyRecord,
    CameraRecord,
    DepthRecord,
    SequenceRecord,
)
from snapfit.models.truth import TRUTH_NAME, truth_line

# Prediction from neighbours gains nothing on noisy depth, and undoing it takes a third of the
# time of decoding. OpenCV before 4.11 cannot leave it out.
_UNFILTERED = (
    [cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_NONE]
    if hasattr(cv2, "IMWRITE_PNG_FILTER_NONE")
    else []
)


class SequenceWriter:
    """Writes frame after frame; `sequence.json` comes last, so that half a sequence is none.

    To be used in a `with` statement: leaving it by an error leaves out `sequence.json`.
    """

    def __init__(
        self,
        directory: Path,
        camera: RgbdCamera,
        *,
        frame_rate_hz: float = 30.0,
        asset: str | None = None,
        bodies: Mapping[str, BodyRecord] | None = None,
        initial_poses: Mapping[str, Pose] | None = None,
        color_format: Literal["jpg", "png"] = "jpg",
        jpeg_quality: int = 92,
        png_compression: int = 1,
        note: str = "",
    ) -> None:
        """Begins a sequence.

        Args:
            directory: made if need be; must not hold a sequence yet.
            camera: of every frame.
            frame_rate_hz: frames a second.
            asset: name of a bundled asset, or of a folder inside `directory`.
            bodies: in place of an asset: parts with meshes inside `directory`.
            initial_poses: `camera_from_body` in the first frame; None takes the first truth.
            color_format: of the colour images.
            jpeg_quality: 0 to 100.
            png_compression: 0 (fast) to 9 (small).
            note: a remark for people.

        Raises:
            SequenceError: there is a sequence already, or the folder cannot be made.
        """
        self._directory = Path(directory)
        self._camera = camera
        self._frame_rate_hz = frame_rate_hz
        self._asset = asset
        self._bodies = dict(bodies or {})
        self._initial_poses = None if initial_poses is None else dict(initial_poses)
        self._color_suffix = f".{color_format}"
        self._color_options = [cv2.IMWRITE_JPEG_QUALITY, jpeg_quality]
        self._png_options = [cv2.IMWRITE_PNG_COMPRESSION, png_compression, *_UNFILTERED]
        if color_format == "png":
            self._color_options = self._png_options
        self._note = note
        self._names: list[str] = []
        self._make_folders()

    def write(
        self,
        name: str,
        color: npt.NDArray[np.uint8],
        depth: npt.NDArray[np.uint16] | None = None,
        truth: GroundTruth | None = None,
    ) -> None:
        """Adds a frame.

        Args:
            name: a plain file name, such as "000200".
            color: (H, W, 3) uint8, BGR.
            depth: (H, W) uint16 in units of the camera's `depth_scale_m`; given if and only if
                there is a depth camera.
            truth: what is true in this frame.

        Raises:
            SequenceError: the images do not fit the camera, or cannot be written.
        """
        self._check(name, color, depth)
        path = self._directory / "color" / (name + self._color_suffix)
        _write_image(path, color, self._color_options)
        if depth is not None:
            _write_image(self._directory / "depth" / f"{name}.png", depth, self._png_options)
        if truth is not None:
            with (self._directory / TRUTH_NAME).open("a", encoding="utf-8") as file:
                file.write(truth_line(truth) + "\n")
            if self._initial_poses is None:
                self._initial_poses = dict(truth.camera_from_body)
        self._names.append(name)

    def finish(self) -> None:
        """Writes `sequence.json`.

        Raises:
            pydantic.ValidationError: what was given makes no sequence (no frame, no part).
        """
        depth = None
        if self._camera.depth is not None:
            depth = DepthRecord.of(
                self._camera.depth,
                depth_scale=self._camera.depth_scale_m,
                depth2color=self._camera.color_from_depth,
            )
        record = SequenceRecord(
            color=CameraRecord.of(self._camera.color),
            depth=depth,
            frames=tuple(self._names),
            fps=self._frame_rate_hz,
            bodies=self._bodies,
            asset=self._asset,
            initial_poses=self._initial_poses or {},
            **({"note": self._note} if self._note else {}),
        )
        content = record.model_dump_json(indent=1, exclude_none=True, exclude_unset=True)
        unfinished = self._directory / f".{SEQUENCE_NAME}"
        unfinished.write_text(content + "\n", encoding="utf-8")
        unfinished.replace(self._directory / SEQUENCE_NAME)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None:
            self.finish()

    def _make_folders(self) -> None:
        if (self._directory / SEQUENCE_NAME).exists():
            raise SequenceError(self._directory, "holds a sequence already: choose another folder")
        try:
            for folder in ["color"] + (["depth"] if self._camera.depth else []):
                (self._directory / folder).mkdir(parents=True, exist_ok=True)
            # What an interrupted writer has left would otherwise be carried on.
            (self._directory / TRUTH_NAME).unlink(missing_ok=True)
        except OSError as error:
            raise SequenceError(self._directory, f"cannot be made: {error.strerror}") from error

    def _check(
        self, name: str, color: npt.NDArray[np.uint8], depth: npt.NDArray[np.uint16] | None
    ) -> None:
        camera = self._camera
        if color.shape != (camera.color.height, camera.color.width, 3) or color.dtype != np.uint8:
            self._refuse(name, "colour", color.shape, color.dtype)
        if (depth is None) != (camera.depth is None):
            problem = "depth is given with a depth camera, and without one it is not"
            raise SequenceError(self._directory, f"frame {name}: {problem}")
        if depth is None or camera.depth is None:
            return
        if depth.shape != (camera.depth.height, camera.depth.width) or depth.dtype != np.uint16:
            self._refuse(name, "depth", depth.shape, depth.dtype)

    def _refuse(self, name: str, which: str, shape: Sequence[int], dtype: object) -> None:
        problem = f"the {which} image is {dtype} {tuple(shape)}, which does not fit the camera"
        raise SequenceError(self._directory, f"frame {name}: {problem}")


def _write_image(path: Path, image: npt.NDArray[np.generic], options: list[int]) -> None:
    done, data = cv2.imencode(path.suffix, image, options)
    if not done:
        raise SequenceError(path, "cannot be encoded")
    try:
        path.write_bytes(data.tobytes())
    except OSError as error:
        raise SequenceError(path, f"cannot be written: {error.strerror}") from error
