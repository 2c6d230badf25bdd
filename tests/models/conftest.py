"""What tests of one bundled asset share: the asset that their file names as `ASSET`."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from bundled_assets import load_bundle


@pytest.fixture(scope="session", autouse=True)
def _solids_end_before_the_interpreter():
    """Solids that outlive it are reported as leaks."""
    yield
    load_bundle.cache_clear()


@pytest.fixture(scope="module")
def bundle(request):
    return load_bundle(request.module.ASSET)


@pytest.fixture(scope="module")
def solids(bundle):
    return bundle.solids


@pytest.fixture(scope="module")
def asset(bundle):
    return bundle.asset


@pytest.fixture(scope="module")
def links(bundle):
    """The links of the assembled product by their children."""
    return bundle.links()
