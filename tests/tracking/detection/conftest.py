"""Networks that say what a test has them say: ONNX files with a constant output."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="session", autouse=True)
def _onnx():
    pytest.importorskip("onnx", reason="onnx is not installed: snapfit[test]")
