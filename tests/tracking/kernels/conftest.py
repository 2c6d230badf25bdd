"""The world that the tests of refinement share."""

import pytest
from worlds import World, make_world


@pytest.fixture(scope="session")
def world() -> World:
    """Made once; nothing in it is changed by a refinement."""
    return make_world()
