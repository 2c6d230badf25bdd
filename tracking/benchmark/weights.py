"""The network of an asset as something that a method is given: another one, another run.

Apart from the other versions, so that finished runs of trackers do not depend on this.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from snapfit.models.asset import Asset
from snapfit.models.detector.card import CARD_NAME, ONNX_NAME
from snapfit.tracking.benchmark.roster import entry


def weights(method: str, asset: Asset | None) -> tuple[Path, ...]:
    """Files of the network that a method uses of an asset; none for one without a network."""
    folder = getattr(entry(method), "network", None)
    if folder is None or asset is None:
        return ()
    return tuple(asset.directory / folder / name for name in (ONNX_NAME, CARD_NAME))


def input_version(data: str, files: Sequence[Path]) -> str:
    """A digest of what a method is given: the sequence, and the network that it uses of the asset.

    Args:
        data: from `data_version`.
        files: of the network, from `weights`; without any it is that of the sequence alone.
    """
    if not files:
        return data
    sha = hashlib.sha256(data.encode())
    for path in files:
        sha.update(path.name.encode())
        # Without the file there is no run: the method says so when it is made.
        sha.update(hashlib.sha256(path.read_bytes()).digest() if path.is_file() else b"")
    return sha.hexdigest()[:16]
