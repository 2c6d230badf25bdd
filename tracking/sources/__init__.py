"""Where frames come from: recordings and cameras."""

from __future__ import annotations

from pathlib import Path

from snapfit.models.asset import Asset, find_asset
from snapfit.tracking.errors import SourceError
from snapfit.tracking.sources.address import parse_address
from snapfit.tracking.sources.base import Source
from snapfit.tracking.sources.cameras import open_camera
from snapfit.tracking.sources.recorded import Loop, RecordedSource, load_recording

MCAP_SUFFIX = ".mcap"

__all__ = ["Loop", "RecordedSource", "Source", "open_any", "open_source"]


def open_any(
    address: str,
    asset: Asset | None = None,
    loop: Loop = "no",
    calibration: Path | None = None,
) -> Source:
    """Opens a camera by its address, or whatever `open_source` opens by its path.

    Args:
        address: such as "realsense:012345", see `parse_address`; or a path.
        asset: the parts that are to be tracked; for a recording in place of its own.
        loop: what comes after the last frame of a recording.
        calibration: camera file of a camera that brings no calibration.

    Raises:
        SourceError: there is no such camera, or a calibration is missing or too much.
        CameraError: the camera file is refused.
        SnapfitError: as `open_source`.
    """
    camera = parse_address(address)
    if camera is not None:
        return open_camera(camera, asset, calibration)
    if calibration is not None:
        problem = "a recording brings its own calibration: leave out station.calibration"
        raise SourceError(f"{address}: {problem}")
    return open_source(address, asset, loop)


def open_source(
    path: Path | str, asset: Asset | Path | str | None = None, loop: Loop = "no"
) -> RecordedSource:
    """Opens a recorded sequence, a BOP scene, or a station's recording (MCAP).

    Args:
        path: its folder, or the `sequence.json` in it; the file of an MCAP recording.
        asset: takes the place of the parts that the recording names: an asset, the name of a
            bundled one, or its folder.
        loop: what comes after the last frame.

    Raises:
        SequenceError: neither a recorded sequence nor a BOP scene, or a broken one.
        RecordingError: no MCAP recording of a station, or a broken one.
        ManifestError: the asset is refused.
        MeshError: a mesh is refused.
    """
    if isinstance(asset, Path | str):
        asset = find_asset(asset)
    if Path(path).suffix == MCAP_SUFFIX:
        # Its libraries are needed for these files alone.
        from snapfit.tracking.recording.source import McapSource

        return McapSource(Path(path), asset, loop)
    return RecordedSource(load_recording(Path(path), asset), loop)
