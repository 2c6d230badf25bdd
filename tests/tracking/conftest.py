"""What the tests of tracking share."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from snapfit.tracking.threads import prepare_threading_layer

# The twins and scenes of the kernels' tests.
sys.path.insert(0, str(Path(__file__).parent / "kernels"))


@pytest.fixture(scope="session", autouse=True)
def _threading_layer() -> None:
    """The first parallel kernel settles the layer for the whole process."""
    prepare_threading_layer()
