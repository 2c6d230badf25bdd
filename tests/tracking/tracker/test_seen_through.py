"""A part cannot be where the depth camera sees what lies behind it, nor where another part is."""

from dataclasses import replace

import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.pose import Pose
from snapfit.tracking.body import load_bodies
from snapfit.tracking.confidence import Evidence
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.recovery.seen_through import SeenThrough

TURN = Pose.exp([0.5, 0.6, -0.3, 0, 0, 0])
HOME = Pose.from_translation(0.02, -0.01, 0.65) @ TURN
REFUTED = Evidence(600, 0, 300, 0, 300, 0, 300)


def nearer(pose: Pose, by_m: float) -> Pose:
    """Moved along its line of sight: the image hardly changes."""
    along = pose.translation / np.linalg.norm(pose.translation)
    return Pose.from_translation(*(-by_m * along)) @ pose


@pytest.fixture(scope="module")
def seen_through(clamp, camera) -> SeenThrough:
    return SeenThrough(load_bodies(clamp[:1]), camera)


def test_what_is_measured_behind_refutes_a_pose(clamp, seen_through, draw) -> None:
    frame = draw(clamp[:1], {clamp[0].name: HOME})
    assert seen_through.contradicts(frame, 0, nearer(HOME, 0.06), REFUTED)
    assert not seen_through.contradicts(frame, 0, HOME, REFUTED)
    assert not seen_through.contradicts(frame, 0, nearer(HOME, -0.06), REFUTED)


def test_points_that_agree_are_believed(clamp, seen_through, draw) -> None:
    frame = draw(clamp[:1], {clamp[0].name: HOME})
    agreeing = replace(REFUTED, supporting_points=100)
    assert not seen_through.contradicts(frame, 0, nearer(HOME, 0.06), agreeing)


def test_missing_depth_and_a_hand_say_nothing(clamp, seen_through, draw) -> None:
    poses = {clamp[0].name: HOME}
    for depth in ("zero", "none"):
        frame = draw(clamp[:1], poses, depth=depth)
        assert not seen_through.contradicts(frame, 0, nearer(HOME, 0.06), REFUTED)
    covered = draw(clamp[:1], poses, cover=(slice(None), slice(None), 0.4))
    assert not seen_through.contradicts(covered, 0, nearer(HOME, 0.06), REFUTED)


def test_outside_the_image_nothing_is_asked(clamp, seen_through, draw) -> None:
    frame = draw(clamp[:1], {clamp[0].name: HOME})
    aside = Pose.from_translation(5.0, 0.0, 0.0) @ HOME
    assert not seen_through.contradicts(frame, 0, aside, REFUTED)


def test_a_hidden_part_does_not_jump_onto_its_twin(clamp, camera, draw) -> None:
    here = HOME
    there = Pose.from_translation(-0.16, 0.0, 0.0) @ HOME
    parts = [clamp[1], replace(clamp[1], name="twin")]
    poses = {parts[0].name: here, "twin": there}
    u, v = camera.color.project(there.translation[None])[0].astype(int)
    cover = (slice(v - 110, v + 110), slice(u - 110, u + 85), 0.45)
    tracker = create_tracker("gbot-without-graph", parts, camera)
    tracker.start(draw(parts, poses), poses)
    tracker.track(draw(parts, poses))
    hidden = draw(parts, poses, cover=cover)
    for _ in range(40):
        first, twin = tracker.track(hidden).parts
        assert first.camera_from_body.distance_to(here) < 0.002
        assert twin.camera_from_body is None or twin.camera_from_body.distance_to(here) > 0.1
    back = tracker.track(draw(parts, poses)).parts[1]
    for _ in range(20):
        back = tracker.track(draw(parts, poses)).parts[1]
    assert back.camera_from_body.distance_to(there) < 0.002


def test_a_place_is_vacant_where_it_is_seen_and_nothing_is_there(clamp, seen_through, draw) -> None:
    frame = draw(clamp[:1], {clamp[0].name: HOME})
    aside = Pose.from_translation(0.2, 0.0, 0.0) @ HOME
    assert seen_through.is_vacant(frame, 0, aside)
    assert not seen_through.is_vacant(frame, 0, HOME)
    covered = draw([], {}, cover=(slice(None), slice(None), 0.4))
    assert not seen_through.is_vacant(covered, 0, HOME)
    assert not seen_through.is_vacant(draw([], {}, depth="none"), 0, HOME)


@pytest.mark.parametrize("is_covered", [True, False])
def test_a_find_far_away_counts_where_the_old_place_is_seen_to_be_empty(
    clamp, camera, draw, is_covered
) -> None:
    jaw = clamp[1]
    here, there = HOME, Pose.from_translation(-0.2, 0.0, 0.0) @ HOME
    tracker = create_tracker("gbot", [jaw], camera, asset=find_asset("hobby-corner-clamp"))
    frame = draw([jaw], {"jaw": here})
    tracker.start(frame, {"jaw": here})
    tracker.track(frame)
    u, v = camera.color.project(here.translation[None])[0].astype(int)
    cover = (slice(v - 110, v + 110), slice(u - 85, u + 110), 0.45)
    after = draw([jaw], {"jaw": there}, **({"cover": cover} if is_covered else {}))
    for _ in range(12):
        tracker.propose({"jaw": [there]})
        said = tracker.track(after).parts[0]
    assert said.camera_from_body.distance_to(here if is_covered else there) < 0.002
