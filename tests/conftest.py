"""What tests of every room share."""

import os
import sys
from pathlib import Path

import pytest
from hypothesis import settings

# `patience`.
sys.path.insert(0, str(Path(__file__).parent))

# The same examples in every run, and none of them may fail because the machine is busy.
settings.register_profile("snapfit", deadline=None, max_examples=60, derandomize=True)
settings.load_profile("snapfit")

_BESIDE_THE_REPOSITORY = Path(__file__).parents[2] / "shared" / "data" / "real_frames"


@pytest.fixture(scope="session")
def real_frames() -> Path:
    """The folder of real RGB-D frames; skips the test where there is none."""
    directory = Path(os.environ.get("SNAPFIT_REAL_FRAMES", _BESIDE_THE_REPOSITORY))
    if not (directory / "sequence.json").is_file():
        pytest.skip(f"no real frames in {directory}: set SNAPFIT_REAL_FRAMES to their folder")
    return directory
