"""Trackers that find their parts by themselves."""

import pytest

from snapfit.models.asset import find_asset
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.create import create_finder, create_offline
from snapfit.tracking.result import Status

ASSET = find_asset("hobby-corner-clamp")


@pytest.mark.usefixtures("needs_open3d")
def test_parts_on_the_bench_are_tracked_without_a_first_pose(clamp, camera, lying, draw) -> None:
    tracker = create_offline("gbot", "geometric", clamp, camera, ASSET, frame_rate_hz=3.0)
    frame = draw(clamp, lying)
    results = [tracker.track(frame) for _ in range(9)]
    # A look for three parts takes more than a frame at this rate.
    assert {each.status for each in results[1].parts} == {Status.SEARCHING}
    assert results[-1].state == "parts-free"
    for each in results[-1].parts:
        assert each.status is Status.TRACKED, each.part
        assert each.camera_from_body.distance_to(lying[each.part]) < 0.003, each.part
        assert each.confidence > 0.9


def test_unknown_detectors_are_named_before_anything_is_made(clamp, bodies, camera) -> None:
    for make in (
        lambda: create_offline("gbot", "magic", clamp, camera, ASSET, 30.0),
        lambda: create_finder("magic", clamp, bodies, camera, ASSET),
    ):
        with pytest.raises(TrackingError, match=r"no detector 'magic'.*geometric, network"):
            make()
