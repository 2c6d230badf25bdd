"""What tests of every room share."""

import os
from pathlib import Path

import pytest

_BESIDE_THE_REPOSITORY = Path(__file__).parents[2] / "shared" / "data" / "real_frames"


@pytest.fixture(scope="session")
def real_frames() -> Path:
    """The folder of real RGB-D frames; skips the test where there is none."""
    directory = Path(os.environ.get("SNAPFIT_REAL_FRAMES", _BESIDE_THE_REPOSITORY))
    if not (directory / "sequence.json").is_file():
        pytest.skip(f"no real frames in {directory}: set SNAPFIT_REAL_FRAMES to their folder")
    return directory
