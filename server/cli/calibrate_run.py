"""What `snapfit calibrate camera` does: gathers views of the board, solves, writes the file."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn

from snapfit.models.calibration import BoardFinder, View, calibrate
from snapfit.models.camera_file import write_camera_file
from snapfit.models.charuco import CharucoBoard
from snapfit.models.errors import CalibrationError
from snapfit.tracking.errors import SourceError
from snapfit.tracking.sources.address import Address, parse_address
from snapfit.tracking.sources.video import open_video

_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
_STILL_PX = 2.0
_NEW_SHARE = 0.05
_GIVEN_UP_READS = 100

Image = npt.NDArray[np.uint8]
Views = tuple[list[View], tuple[int, int]]


def run(source: str, out: Path, board: CharucoBoard, n_views: int) -> None:
    """Calibrates one camera.

    Args:
        source: a folder of images, or the address of a USB or network camera.
        out: the camera file.
        board: that is seen.
        n_views: of a camera, how many are taken.

    Raises:
        CalibrationError: what was seen does not do.
        SourceError: there is no such camera.
        CameraError: the file cannot be written.
    """
    console = Console(highlight=False)
    address = parse_address(source)
    if address is None:
        views, size = _from_folder(Path(source), BoardFinder(board), console)
    elif address.kind in ("uvc", "rtsp"):
        views, size = _from_camera(address, BoardFinder(board), n_views, console)
    else:
        raise SourceError(f"{source}: this camera brings its own calibration: use it as it is")
    file = calibrate(views, size, board)
    write_camera_file(out, file)
    console.print(
        f"{out}: {file.width}x{file.height}, focal length {file.fx:.1f}, {file.fy:.1f} px, "
        f"error {file.rms_px:.2f} px (RMS) over {file.images} images",
        soft_wrap=True,
    )


def _from_folder(folder: Path, finder: BoardFinder, console: Console) -> Views:
    if not folder.is_dir():
        raise CalibrationError(f"{folder}: no such folder")
    paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in _SUFFIXES)
    if not paths:
        raise CalibrationError(f"{folder}: there is no image in it ({', '.join(_SUFFIXES)})")
    views: list[View] = []
    size: tuple[int, int] | None = None
    for path in paths:
        image = cv2.imdecode(np.frombuffer(path.read_bytes(), np.uint8), cv2.IMREAD_COLOR)
        if image is None:
            console.print(f"[yellow]skipped[/yellow] {path.name}: is no image that can be read")
            continue
        its_size = (int(image.shape[1]), int(image.shape[0]))
        if size is not None and its_size != size:
            problem = f"is {its_size[0]}x{its_size[1]}, the others are {size[0]}x{size[1]}"
            raise CalibrationError(f"{path}: {problem}: use images of one camera at one size")
        size = its_size
        view = finder.find(path.name, np.asarray(image, dtype=np.uint8))
        if view is None:
            console.print(f"[yellow]skipped[/yellow] {path.name}: the board is not seen well")
        else:
            views.append(view)
    return views, size or (0, 0)


def _from_camera(address: Address, finder: BoardFinder, n_views: int, console: Console) -> Views:
    capture = open_video(address)
    try:
        if not capture.isOpened():
            raise SourceError(f"{address.text}: there is no such camera, or it is in use")
        gathered = _Gathered()
        columns = SpinnerColumn(), TextColumn("{task.description}")
        with (
            Progress(*columns, console=console, transient=True) as progress,
            suppress(KeyboardInterrupt),
        ):
            task = progress.add_task("show the board to the camera")
            while len(gathered.views) < n_views:
                gathered.take(_next_image(capture, address), finder)
                told = f"{len(gathered.views)} of {n_views} views: {gathered.advice}"
                progress.update(task, description=f"{told}; Ctrl-C ends it")
    finally:
        capture.release()
    return gathered.views, gathered.size


def _next_image(capture: cv2.VideoCapture, address: Address) -> Image:
    for _ in range(_GIVEN_UP_READS):
        is_there, image = capture.read()
        if is_there and image is not None:
            return np.asarray(image, dtype=np.uint8)
    raise SourceError(f"{address.text}: delivers no image any more")


class _Gathered:
    """Views that are worth something: the board at rest, and not where it was before."""

    def __init__(self) -> None:
        self.views: list[View] = []
        self.size = (0, 0)
        self.advice = ""
        self._last: View | None = None

    def take(self, image: Image, finder: BoardFinder) -> None:
        """Looks into the next image."""
        self.size = (int(image.shape[1]), int(image.shape[0]))
        view = finder.find(f"view {len(self.views) + 1}", image)
        last, self._last = self._last, view
        if view is None:
            self.advice = "the board is not seen"
        elif last is None or _moved_px(view, last) > _STILL_PX:
            self.advice = "hold it still"
        elif any(_moved_px(view, each) < _NEW_SHARE * self.size[0] for each in self.views):
            self.advice = "move it on, tilt it, bring it to the edges"
        else:
            self.views.append(view)
            self.advice = "taken"


def _moved_px(a: View, b: View) -> float:
    """How far the corners that both views have went on average; infinite where there are none."""
    there = {
        tuple(point): pixel for point, pixel in zip(a.points_m.tolist(), a.pixels, strict=True)
    }
    moved = [
        float(np.linalg.norm(there[tuple(point)] - pixel))
        for point, pixel in zip(b.points_m.tolist(), b.pixels, strict=True)
        if tuple(point) in there
    ]
    return float(np.mean(moved)) if moved else float("inf")
