"""Where frames come from: recordings now, cameras later."""

from __future__ import annotations

from pathlib import Path

from snapfit.models.asset import Asset, find_asset
from snapfit.tracking.sources.base import Source
from snapfit.tracking.sources.recorded import Loop, RecordedSource, load_recording

__all__ = ["Loop", "RecordedSource", "Source", "open_source"]


def open_source(
    path: Path | str, asset: Asset | Path | str | None = None, loop: Loop = "no"
) -> RecordedSource:
    """Opens a recorded sequence or a BOP scene.

    Args:
        path: its folder, or the `sequence.json` in it.
        asset: takes the place of the parts that the recording names: an asset, the name of a
            bundled one, or its folder.
        loop: what comes after the last frame.

    Raises:
        SequenceError: neither a recorded sequence nor a BOP scene, or a broken one.
        ManifestError: the asset is refused.
        MeshError: a mesh is refused.
    """
    if isinstance(asset, Path | str):
        asset = find_asset(asset)
    return RecordedSource(load_recording(Path(path), asset), loop)
