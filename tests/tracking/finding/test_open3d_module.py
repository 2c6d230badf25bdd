"""Without Open3D the geometric finder says what to install."""

import importlib
import subprocess
import sys

import pytest

from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.geometric import GeometricFinder
from snapfit.tracking.finding.open3d_module import open3d


@pytest.mark.parametrize(
    "cause",
    [
        ModuleNotFoundError("No module named 'open3d'"),
        ImportError("libGL.so.1: cannot open shared object file"),
        OSError("libX11.so.6: cannot open shared object file"),
    ],
)
def test_it_tells_what_is_missing_and_what_to_install(monkeypatch, cause):
    def missing(name: str) -> None:
        raise cause

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(TrackingError) as caught:
        open3d()
    assert str(cause) in str(caught.value)
    assert "pip install open3d" in str(caught.value)
    assert "apt-get install libgl1" in str(caught.value)


def test_a_finder_without_open3d_is_refused_when_it_is_made(monkeypatch, bodies, camera):
    def missing(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r}")

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(TrackingError, match="needs Open3D"):
        GeometricFinder(bodies, camera)


def test_numba_still_has_its_threads_when_open3d_came_first(needs_open3d):
    # Open3D's own TBB, loaded first, would switch Numba's threading layer off with a warning.
    script = (
        "from snapfit.tracking.finding.open3d_module import open3d; open3d()\n"
        "import numba, numpy, warnings; warnings.simplefilter('error')\n"
        "double = numba.njit(parallel=True)(lambda values: values * 2)\n"
        "print(int(double(numpy.arange(5)).sum()))\n"
    )
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=400, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "20"), done.stderr
