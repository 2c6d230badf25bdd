"""The assembly graph at work on drawn frames: linking, carrying, going back, finding again."""

import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.pose import Pose
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.methods import METHODS, create_tracker
from snapfit.tracking.result import Status

HOME = Pose.from_rotation_translation(
    Pose.exp([2.2, 0.3, -0.3, 0, 0, 0]).rotation, (0.02, 0.02, 0.6)
)
BASE_ALONE = Pose.from_translation(0.12, -0.02, 0)


@pytest.fixture(scope="module")
def asset():
    return find_asset("hobby-corner-clamp")


@pytest.fixture(scope="module")
def seat(asset) -> Pose:
    """base_from_jaw when the jaw is mounted."""
    link = next(each for each in asset.states[1].links if each.child == "jaw")
    return link.parent_from_child


@pytest.fixture
def pair(clamp):
    return [part for part in clamp if part.name in ("base", "jaw")]


def tracker_of(asset, pair, camera, method="gbot"):
    return create_tracker(method, pair, camera, asset=asset)


def jaw_at(base: Pose, seat: Pose, apart_m: float) -> dict[str, Pose]:
    """The jaw above its seat, along the base's z axis."""
    return {"base": base, "jaw": base @ Pose.from_translation(0, 0, apart_m) @ seat}


def mounted(tracker, pair, draw, seat):
    """Brings the jaw to its seat; returns the poses at the end and all results."""
    poses = jaw_at(HOME, seat, 0.08)
    tracker.start(draw(pair, poses), poses)
    results = []
    for apart_m in [*np.arange(0.08, 0.0, -0.005), *([0.0] * 8)]:
        poses = jaw_at(HOME, seat, apart_m)
        results.append(tracker.track(draw(pair, poses)))
    return poses, results


def of(result, part):
    return next(each for each in result.parts if each.part == part)


def test_a_part_that_reaches_its_place_is_linked_and_the_step_is_done(
    asset, pair, camera, draw, seat
) -> None:
    poses, results = mounted(tracker_of(asset, pair, camera), pair, draw, seat)
    states = [result.state for result in results]
    assert states[:12] == ["parts-free"] * 12
    assert states[-1] == "jaw-mounted"
    jaw = of(results[-1], "jaw")
    assert jaw.linked_to in (None, "base")
    assert jaw.camera_from_body.distance_to(poses["jaw"]) < 0.003
    assert results[-1].assembly.finished_steps == ("mount-jaw",)


def test_a_hidden_part_goes_where_its_link_takes_it(asset, pair, camera, draw, seat) -> None:
    tracker = tracker_of(asset, pair, camera)
    poses, _ = mounted(tracker, pair, draw, seat)
    shown = camera.color.project(poses["jaw"].transform(pair[1].mesh.vertices))
    left, top = shown.min(axis=0).astype(int) - 8
    right, bottom = shown.max(axis=0).astype(int) + 8
    for step in range(8):
        base = Pose.from_translation(0.002 * step, 0, 0) @ HOME
        poses = jaw_at(base, seat, 0.0)
        cover = (slice(top, bottom), slice(left, right + 16), 0.35)
        result = tracker.track(draw(pair, poses, cover=cover))
    jaw = of(result, "jaw")
    assert jaw.status is Status.INFERRED
    assert jaw.linked_to == "base"
    assert jaw.camera_from_body.distance_to(poses["jaw"]) < 0.003
    assert np.degrees(jaw.camera_from_body.angle_to(poses["jaw"])) < 3


def test_a_hidden_part_stays_where_it_was_on_its_joint(asset, pair, camera, draw, seat) -> None:
    """Also when something before it is taken for it, and moves it along."""
    tracker = tracker_of(asset, pair, camera)
    poses, _ = mounted(tracker, pair, draw, seat)
    structures = tracker._optimiser.structures
    jaw = tracker.names.index("jaw")
    assert structures.arrays.n_dof[jaw] == 1
    shown = camera.color.project(poses["jaw"].transform(pair[1].mesh.vertices))
    left, top = shown.min(axis=0).astype(int) - 8
    right, bottom = shown.max(axis=0).astype(int) + 8
    cover = (slice(top, bottom), slice(left, right), 0.35)
    tracker.track(draw(pair, poses, cover=cover))
    place = structures.arrays.q[jaw].copy()
    structures.arrays.q[jaw, 0] += 0.008
    structures.place(structures.root(jaw), tracker._optimiser.poses)
    result = tracker.track(draw(pair, poses, cover=cover))
    assert of(result, "jaw").status is Status.INFERRED
    assert structures.arrays.q[jaw] == pytest.approx(place, abs=1e-9)


def test_a_part_that_comes_off_undoes_the_step(asset, pair, camera, draw, seat) -> None:
    tracker = tracker_of(asset, pair, camera)
    mounted(tracker, pair, draw, seat)
    for apart_m in [*np.arange(0.0, 0.1, 0.004), *([0.1] * 12)]:
        poses = jaw_at(HOME, seat, apart_m)
        result = tracker.track(draw(pair, poses))
    assert result.state == "parts-free"
    assert of(result, "jaw").linked_to is None
    assert of(result, "jaw").camera_from_body.distance_to(poses["jaw"]) < 0.003


def test_the_published_graph_only_goes_forward(asset, pair, camera, draw, seat) -> None:
    tracker = tracker_of(asset, pair, camera, "gbot-paper")
    _, results = mounted(tracker, pair, draw, seat)
    assert results[-1].state == "jaw-mounted"
    # At 3 cm it has switched: long before the part is in its place.
    assert [result.state for result in results].index("jaw-mounted") <= 12
    for apart_m in np.arange(0.0, 0.1, 0.01):
        result = tracker.track(draw(pair, jaw_at(HOME, seat, apart_m)))
    assert result.state == "jaw-mounted"


def test_a_part_that_was_moved_behind_a_hand_is_found_again(
    asset, pair, camera, draw, seat
) -> None:
    tracker = tracker_of(asset, pair, camera)
    poses = jaw_at(HOME, seat, 0.09)
    tracker.start(draw(pair, poses), poses)
    for _ in range(3):
        tracker.track(draw(pair, poses))
    everywhere = (slice(None), slice(None), 0.3)
    for _ in range(5):
        hidden = of(tracker.track(draw(pair, poses, cover=everywhere)), "jaw")
    assert hidden.status is Status.PREDICTED
    away = Pose.from_translation(-0.06, -0.02, 0.01) @ poses["jaw"]
    moved = {**poses, "jaw": away @ Pose.exp([0.2, 0.1, 0.3, 0, 0, 0])}
    for _ in range(20):
        found = of(tracker.track(draw(pair, moved)), "jaw")
    assert found.status is Status.TRACKED
    assert found.camera_from_body.distance_to(moved["jaw"]) < 0.003


def test_a_told_structure_is_linked_at_once(asset, pair, camera, draw, seat) -> None:
    assert METHODS["mbicg"].needs_true_state
    tracker = tracker_of(asset, pair, camera, "mbicg")
    poses = jaw_at(HOME, seat, 0.0)
    tracker.start(draw(pair, poses), poses)
    tracker.set_state("jaw-mounted")
    result = tracker.track(draw(pair, poses))
    assert result.state == "jaw-mounted"
    assert of(result, "jaw").linked_to == "base"
    for _ in range(20):
        assert tracker.track(draw(pair, jaw_at(HOME, seat, 0.0))).state == "jaw-mounted"


def test_what_a_method_needs_is_asked_for(asset, pair, camera) -> None:
    with pytest.raises(TrackingError, match="follows an assembly graph: name an asset"):
        create_tracker("gbot", pair, camera)
    with pytest.raises(TrackingError, match="no state to set"):
        create_tracker("icg", pair, camera, asset=asset).set_state("jaw-mounted")
    with pytest.raises(TrackingError, match="no assembly state 'nope'"):
        tracker_of(asset, pair, camera).set_state("nope")
