"""Views of training images: labels must lie where the picture shows the parts, however it turns."""

from dataclasses import replace

import numpy as np
import pytest

from snapfit.models.asset import find_asset
from snapfit.models.detector.samples import training_sample, whole_sample
from snapfit.models.detector.shapes import part_shapes
from snapfit.models.detector.views import ViewParameters, relit, sampled_view
from snapfit.models.errors import DatasetError
from snapfit.models.keypoints import canonical_pose
from snapfit.models.train_reader import TrainClass, TrainSet
from snapfit.models.workbench.train_set import TrainOrder, render_train_set

# It has parts with an axis, with discrete turns, and with none.
ASSET = "nano-chuck"
PLAIN = ViewParameters(tiled_share=0.0)
TURNED = replace(PLAIN, roll_deg=60)


@pytest.fixture(scope="module")
def images(tmp_path_factory):
    folder = tmp_path_factory.mktemp("images")
    render_train_set(TrainOrder(folder, (ASSET,), count=8, seed=3, scale=0.5), jobs=1)
    return TrainSet(folder / ASSET)


@pytest.fixture(scope="module")
def shapes(images):
    return part_shapes(find_asset(ASSET), images.classes)


def views(images, count=12):
    for i in range(count):
        camera = images[i % len(images)].labels.camera
        rng = np.random.default_rng(i)
        size = camera.width, camera.height
        part = np.array([*rng.uniform((0, 0), size), 0, 0])
        part[2:] = part[:2] + 30
        view = sampled_view(size, part, ViewParameters(roll_deg=40), rng)
        yield images[i % len(images)], view


def test_the_picture_lies_where_the_places_do(images):
    for _, view in views(images):
        image = np.full((270, 480, 3), 114, dtype=np.uint8)
        # Where the view's own middle comes from.
        turn, shift = view.matrix[:, :2], view.matrix[:, 2]
        u, v = np.linalg.inv(turn) @ (np.array([view.width, view.height]) / 2 - shift) - 0.5
        u, v = round(float(np.clip(u, 5, 474))), round(float(np.clip(v, 5, 264)))
        image[v - 2 : v + 3, u - 2 : u + 3] = 255
        shown = view.picture(image)[..., 0].astype(float) - 114
        rows, columns = np.indices(shown.shape)
        found = np.array([(columns * shown).sum(), (rows * shown).sum()]) / shown.sum() + 0.5
        assert np.abs(found - view.places(np.array([u, v]))).max() < 0.35


def test_a_rolled_camera_gives_a_symmetric_part_its_canonical_pose(images, shapes):
    """The labels of a rolled view are those of the same part seen by a camera that is rolled."""
    symmetric = {part.name for part in find_asset(ASSET).parts if not part.symmetry.is_none}
    moved = 0
    for k in range(8):
        sample = images[k]
        rng = np.random.default_rng(k)
        found = training_sample([sample], shapes, TURNED, rng)
        view = view_of(sample, TURNED, np.random.default_rng(k))
        camera = sample.labels.camera
        expected = []
        for each in sample.labels.instances:
            shape = shapes[each.part]
            rolled = view.unrolled.inverse() @ each.camera_from_body
            canonical = canonical_pose(rolled, shape.symmetry)
            # Pixels of the image are those of the camera as it was.
            points = view.unrolled.transform(canonical.transform(shape.keypoints_m))
            expected.append((shape.number, view.places(camera.project(points))))
            if each.part in symmetric:
                moved += canonical.angle_to(rolled) > 0.01
        for number, keypoints in zip(found.classes, found.keypoints, strict=True):
            distances = [
                np.abs(pixels - keypoints[:, :2]).max()
                for other, pixels in expected
                if other == number
            ]
            assert min(distances) < 1e-3
    assert moved > 0


def view_of(sample, parameters, rng):
    """The view that `training_sample` draws first."""
    from snapfit.models.detector import samples

    rng.random()
    boxes = [samples._box(each) for each in sample.labels.instances if samples._is_seen(each)]
    boxes = rng.permutation(np.array(boxes, dtype=np.float64).reshape(-1, 4))
    camera = sample.labels.camera
    aim = boxes[0] if len(boxes) else None
    return sampled_view((camera.width, camera.height), aim, parameters, rng)


def test_tiles_fill_a_view_and_show_a_part_each(images, shapes):
    parameters = ViewParameters(tiled_share=1.0, tiles=(2, 3))
    found = training_sample(list(images)[:3], shapes, parameters, np.random.default_rng(1))
    assert found.picture.shape == (256, 384, 3)
    tiles = {
        (int(x // 128), int(y // 128)) for x, y in (found.boxes[:, :2] + found.boxes[:, 2:]) / 2
    }
    assert len(tiles) == 6
    # No box reaches from one tile into the next.
    assert (found.boxes[:, 0] // 128 == (found.boxes[:, 2] - 1e-3) // 128).all()


def test_the_same_seed_gives_the_same_view(images, shapes):
    few = list(images)[:3]
    first, again, other = (
        training_sample(few, shapes, ViewParameters(), np.random.default_rng(seed))
        for seed in (5, 5, 6)
    )
    np.testing.assert_array_equal(first.picture, again.picture)
    np.testing.assert_array_equal(first.keypoints, again.keypoints)
    assert not np.array_equal(first.picture, other.picture)


def test_a_whole_image_keeps_its_labels(images, shapes):
    parameters = ViewParameters(height_px=288, width_px=480)
    for sample in images:
        found = whole_sample(sample, shapes, parameters)
        assert found.picture.shape == (288, 480, 3)
        given = np.stack([each.keypoints[:, :2] for each in sample.labels.instances])
        # 480x270 in 480x288: nine rows of grey above, and edges at 0 in place of middles.
        np.testing.assert_allclose(
            found.keypoints[..., :2], given + np.array([0.5, 9.5]), atol=0.02
        )
        inside = np.stack([each.keypoints[:, 2] > 0 for each in sample.labels.instances])
        assert (found.keypoints[..., 2][inside] == 1).all()
        hidden = [each.visibility < 0.1 or each.n_seen < 40 for each in sample.labels.instances]
        assert found.is_ignored[np.array(hidden)].all()


def test_light_changes_and_nothing_is_mirrored():
    rng = np.random.default_rng(0)
    picture = np.tile(np.arange(64, dtype=np.uint8)[None, :, None] * 4, (32, 1, 3))
    for _ in range(20):
        lit = relit(picture, ViewParameters(), rng).astype(int)
        assert (np.diff(lit, axis=1) >= 0).all()
    for _ in range(20):
        view = sampled_view((640, 480), None, ViewParameters(roll_deg=90), rng)
        assert np.linalg.det(view.matrix[:, :2]) > 0


def test_a_part_that_the_asset_has_not_is_refused():
    strange = TrainClass("lid", 0, np.zeros((4, 3)))
    with pytest.raises(DatasetError, match="no part 'lid'"):
        part_shapes(find_asset(ASSET), [strange])


def test_a_turned_picture_and_its_boxes_agree(images, shapes):
    """The box is where the part is seen in the image, by its mask, and no larger than needed."""
    checked = 0
    for k in range(8):
        sample = images[k]
        labels = sample.labels
        found = training_sample([sample], shapes, TURNED, np.random.default_rng(k))
        view = view_of(sample, TURNED, np.random.default_rng(k))
        for each in labels.instances:
            number = shapes[each.part].number
            if sum(other.part == each.part for other in labels.instances) > 1:
                continue
            rows, columns = np.nonzero(each.mask(labels.camera))
            places = view.places(np.column_stack([columns, rows]).astype(float))
            inside = places[((places > 0) & (places < (view.width, view.height))).all(axis=1)]
            if len(inside) == 0:
                continue
            (box,) = found.boxes[found.classes == number]
            assert (inside.min(axis=0) > box[:2] - 1.5).all()
            assert (inside.max(axis=0) < box[2:] + 1.5).all()
            if each.visibility > 0.99 and len(inside) == len(places):
                assert np.abs(inside.min(axis=0) - box[:2]).max() < 2.5
                assert np.abs(inside.max(axis=0) - box[2:]).max() < 2.5
                checked += 1
    assert checked > 3
