"""Tracks of the bundled assets, made once a run."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path

import pytest

from snapfit.models.asset import bundled_names

sys.path.insert(0, str(Path(__file__).parent))

from tracks import Track, track_of

_N_FRAMES = 450


@cache
def _track(name: str) -> Track:
    return track_of(name, _N_FRAMES, seed=5)


@pytest.fixture(scope="session", params=bundled_names())
def track(request: pytest.FixtureRequest) -> Track:
    return _track(str(request.param))
