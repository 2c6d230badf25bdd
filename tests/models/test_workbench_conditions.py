"""Light, blur and hand: each does what it says, and truth agrees with the picture."""

import hashlib
import itertools

import cv2
import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.models.workbench.film import Film
from snapfit.models.workbench.grasp import HandScript
from snapfit.models.workbench.hand import Person, hand_bodies
from snapfit.models.workbench.light import moving_lamp
from snapfit.models.workbench.split import EFFECTS, FRAME_RATE_HZ, TEST_FRAMES, Condition
from snapfit.models.workbench.summary import hidden_stretches

N_FRAMES = TEST_FRAMES["hobby-corner-clamp"]
FAST = 30


@pytest.fixture(scope="module")
def film():
    return Film(find_asset("hobby-corner-clamp"), N_FRAMES, 2001, scale=0.25)


@pytest.fixture(scope="module")
def fast(film):
    """The frame in which a part goes fastest."""
    moved = []
    for index in range(1, N_FRAMES - 1):
        a, b = (film.script.poses_at((index + d) / FRAME_RATE_HZ) for d in (-0.5, 0.5))
        moved.append(max(a[name].distance_to(b[name]) for name in ("jaw", "bolt")))
    return int(np.argmax(moved)) + 1


def difference(a, b):
    return np.abs(a.color.astype(int) - b.color.astype(int)).max(axis=-1)


@pytest.mark.parametrize("condition", list(Condition))
def test_a_seed_gives_the_same_bytes_whatever_came_before(film, fast, condition):
    one = film.frame(fast, condition)
    film.frame(fast + 90, condition)
    again = film.frame(fast, condition)
    for a, b in ((one.color, again.color), (one.depth, again.depth)):
        assert hashlib.sha256(a).digest() == hashlib.sha256(b).digest()


def test_truth_is_the_same_under_all_conditions(film, fast):
    frames = [film.frame(fast, condition) for condition in Condition]
    for frame in frames[1:]:
        assert frame.state == frames[0].state
        for name, sighting in frame.sightings.items():
            own = sighting.camera_from_body.matrix
            assert (own == frames[0].sightings[name].camera_from_body.matrix).all()


def test_masks_boxes_and_depth_agree_with_the_poses(film, fast):
    frame = film.frame(fast, Condition.NORMAL)
    poses = [each.camera_from_body for each in frame.sightings.values()]
    parts = film.asset.parts
    bodies = [(part.mesh, pose) for part, pose in zip(parts, poses, strict=True)]
    seen = render(film.camera.color, bodies)
    for i, sighting in enumerate(frame.sightings.values()):
        own = seen.part_id == i + 1
        assert (own != sighting.mask).sum() <= 0.03 * own.sum() + 3
        rows, columns = np.nonzero(sighting.mask)
        x, y, width, height = sighting.box_seen
        assert (x, y) == (columns.min(), rows.min())
        assert (x + width, y + height) == (columns.max() + 1, rows.max() + 1)
        assert sighting.n_seen == sighting.mask.sum() <= sighting.n_pixels
        inside = cv2.erode(sighting.mask.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        measured = inside & (frame.depth > 0)
        off_mm = frame.depth[measured] - seen.depth[measured] * 1000
        assert np.median(np.abs(off_mm)) < 3


def test_the_moving_light_goes_around_above_the_bench():
    places = np.array([moving_lamp(i / FRAME_RATE_HZ, 0.3).position_m for i in range(400)])
    middle = np.array([0, 0.05, 0])
    assert np.ptp(np.linalg.norm(places - middle, axis=1)) < 1e-9
    assert places[:, 2].min() > 0.3
    assert len({(x > 0, y > 0) for x, y, _ in np.sign(places - middle)}) == 4
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert 0.005 < steps.min() < steps.max() < 0.05


def test_the_moving_light_changes_the_picture_where_nothing_moves(film):
    one, other = film.frame(1, Condition.DYNAMIC), film.frame(10, Condition.DYNAMIC)
    still, stays = film.frame(1, Condition.NORMAL), film.frame(10, Condition.NORMAL)
    assert np.quantile(difference(one, other), 0.9) > 12
    assert np.quantile(difference(still, stays), 0.9) < 12


def test_blur_is_there_only_where_something_moves(film, fast):
    assert EFFECTS[Condition.BLUR].exposure >= 0.5
    part = film.frame(fast, Condition.NORMAL).in_hand
    sharp, blurred = (film.frame(fast, c) for c in (Condition.NORMAL, Condition.BLUR))
    mask = sharp.sightings[part].mask.astype(np.uint8)
    around = cv2.dilate(mask, np.ones((5, 5), np.uint8)) > 0

    def edges(frame):
        return np.abs(cv2.Laplacian(frame.color, cv2.CV_32F)).max(axis=-1)

    assert edges(blurred)[around].mean() < 0.93 * edges(sharp)[around].mean()
    far = cv2.dilate(mask, np.ones((3, 3), np.uint8), iterations=60) == 0
    assert edges(blurred)[far].mean() == pytest.approx(edges(sharp)[far].mean(), rel=0.05)


def test_a_blurred_picture_at_rest_is_that_of_the_normal_condition(film):
    rest, blurred = film.frame(3, Condition.NORMAL), film.frame(3, Condition.BLUR)
    assert np.quantile(difference(rest, blurred), 0.99) < 16


def test_the_hand_hides_parts_in_colour_and_depth(film, fast):
    bare, held = (film.frame(fast, c) for c in (Condition.NORMAL, Condition.HAND))
    part = bare.in_hand
    lost = bare.sightings[part].mask & ~held.sightings[part].mask
    assert lost.sum() > 20
    assert difference(bare, held)[lost].mean() > 20
    both = lost & (bare.depth > 0) & (held.depth > 0)
    assert np.median(bare.depth[both].astype(int) - held.depth[both]) > 5
    assert held.sightings[part].n_pixels == bare.sightings[part].n_pixels


def test_the_moving_part_is_hidden_as_much_as_stated(film):
    seen = []
    for index in range(0, N_FRAMES, 3):
        frame = film.frame(index, Condition.HAND)
        seen.append(None if frame.in_hand is None else frame.sightings[frame.in_hand].visibility)
    known = [share for share in seen if share is not None]
    assert 0.2 < np.mean(known) <= 0.6
    runs = itertools.groupby(share is not None and share < 0.15 for share in seen)
    long = [len(list(run)) for hidden, run in runs if hidden]
    assert sum(3 * n >= 15 for n in long) >= 2


def test_hidden_stretches_are_counted():
    seen = [0.1] * 15 + [0.5] + [0.0] * 14 + [None] + [0.14] * 20
    assert hidden_stretches(seen) == [15, 20]


def test_the_hand_follows_the_part_and_moves_smoothly(film):
    eye = film.scene.camera_from_world.inverse().translation
    meshes = {part.name: part.mesh for part in film.asset.parts}
    hand = HandScript(film.script, meshes, eye, np.random.default_rng(0))
    places = []
    for index in range(N_FRAMES):
        time_s = index / FRAME_RATE_HZ
        palm = hand.bodies_at(time_s)[0].world_from_body.translation
        places.append(palm)
        for grasp in hand.grasps:
            if grasp.start_s <= time_s <= grasp.end_s:
                pose = film.script.poses_at(time_s)[grasp.part]
                points = pose.transform(meshes[grasp.part].vertices)
                assert np.linalg.norm(points - palm, axis=1).min() < 0.10
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert steps.max() < 0.12


def test_a_hand_has_bones_that_hang_together():
    person = Person.sampled(np.random.default_rng(0))
    shoulder = np.array([0.3, -0.7, 0.1])
    for curl in (0.0, 0.5, 1.0):
        bodies = hand_bodies(Pose.from_translation(0, 0, 0.2), curl, person, shoulder)
        assert len(bodies) >= 20
        clouds = [body.world_from_body.transform(body.mesh.vertices) for body in bodies]
        # Of the long bones of the arm only the ends have vertices.
        for i in (0, 1, *range(4, len(clouds))):
            rest = np.vstack([other for j, other in enumerate(clouds) if j != i])
            gap = np.linalg.norm(clouds[i][:, None] - rest[None, ::3], axis=-1).min()
            assert gap < 0.01
        wrist = clouds[2][np.linalg.norm(clouds[2] - shoulder, axis=1).argmax()]
        assert np.linalg.norm(clouds[0] - wrist, axis=1).min() < 0.02
