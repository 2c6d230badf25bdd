"""Places where a picture cannot tell whether a part is there."""

from snapfit.models.asset import find_asset
from snapfit.tracking.assembly.unclear import unclear_places


def of(name: str) -> frozenset[str]:
    asset = find_asset(name)
    return unclear_places(asset.tracked_parts, asset.states)


def test_a_cover_on_a_plate_of_its_own_colour_is_unclear() -> None:
    assert of("geared-caliper") == {"move-top-vernier"}


def test_parts_of_other_colours_or_that_stand_out_are_clear() -> None:
    assert of("hobby-corner-clamp") == frozenset()
    assert of("liftpod") == frozenset()
