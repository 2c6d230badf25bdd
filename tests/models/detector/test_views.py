"""Views of training images: labels must lie where the picture shows the parts, however it turns."""

from dataclasses import replace

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="PyTorch is not installed: snapfit[train]")

from snapfit.models.asset import find_asset
from snapfit.models.detector.batches import Course, aimed_boxes, joined, whole_batches
from snapfit.models.detector.cutting import cut_out, relit
from snapfit.models.detector.device import CPU
from snapfit.models.detector.label_table import label_table
from snapfit.models.detector.pictures import HeldPictures, ReadPictures
from snapfit.models.detector.shape_table import canonical, shape_table
from snapfit.models.detector.shapes import part_shapes
from snapfit.models.detector.targets import Targets
from snapfit.models.detector.view_batch import ViewBatch, labelled, sampled_views
from snapfit.models.detector.views import ViewParameters
from snapfit.models.errors import DatasetError
from snapfit.models.keypoints import canonical_pose
from snapfit.models.pose import Pose
from snapfit.models.train_reader import TrainClass, TrainSet
from snapfit.models.workbench.train_set import TrainOrder, render_train_set

# It has parts with an axis, with discrete turns, and with none.
ASSET = "nano-chuck"
WIDE = ViewParameters(roll_deg=60)


@pytest.fixture(scope="module")
def images(tmp_path_factory):
    folder = tmp_path_factory.mktemp("images")
    render_train_set(TrainOrder(folder, (ASSET,), count=8, seed=3, scale=0.5), jobs=1)
    return TrainSet(folder / ASSET)


@pytest.fixture(scope="module")
def shapes(images):
    return part_shapes(find_asset(ASSET), images.classes)


@pytest.fixture(scope="module")
def table(images, shapes):
    return label_table([(list(images), shapes)])


def turned_views(table, count=8, seed=0):
    generator = torch.Generator().manual_seed(seed)
    which = torch.arange(count) % len(table)
    aims = aimed_boxes(table, which, torch.arange(count), torch.zeros(count).long(), generator)
    return sampled_views(table, which, aims, (384, 256), WIDE, 1.0, generator)


def places(views, k, pixels):
    """(N, 2) image pixels, centres at integers, to places in view k."""
    matrix = views.matrices[k].numpy().astype(np.float64)
    return (pixels + 0.5) @ matrix[:, :2].T + matrix[:, 2]


def test_the_picture_lies_where_the_places_do(table):
    views = turned_views(table)
    width, height = table.size
    for k in range(len(views)):
        image = np.full((height, width), 114, dtype=np.int32)
        # Where the view's own middle comes from.
        turn, shift = views.matrices[k, :, :2].numpy(), views.matrices[k, :, 2].numpy()
        u, v = np.linalg.inv(turn) @ (np.array([384, 256]) / 2 - shift) - 0.5
        u, v = round(float(np.clip(u, 5, width - 6))), round(float(np.clip(v, 5, height - 6)))
        image[v - 2 : v + 3, u - 2 : u + 3] = 255
        memory = torch.from_numpy((image << 16 | image << 8 | image).reshape(1, -1))
        one = ViewBatch(
            *(t[k : k + 1] for t in (views.images, views.matrices, views.rolls)), 384, 256
        )
        shown = cut_out(memory, torch.zeros(1).long(), table.size, one)[0, 0].numpy() - 114.0
        rows, columns = np.indices(shown.shape)
        found = np.array([(columns * shown).sum(), (rows * shown).sum()]) / shown.sum() + 0.5
        assert np.abs(found - places(views, k, np.array([u, v]))).max() < 0.35


def test_colours_keep_their_places_and_what_lies_beyond_is_grey():
    image = np.full((4, 6), 10 | 20 << 8 | 30 << 16, dtype=np.int32)
    memory = torch.from_numpy(image.reshape(1, -1))
    matrix = torch.tensor([[[1.0, 0, 2], [0, 1, 0]]])
    views = ViewBatch(torch.zeros(1).long(), matrix, torch.zeros(1), 8, 4)
    shown = cut_out(memory, torch.zeros(1).long(), (6, 4), views)[0]
    assert shown[:, 1, 4].tolist() == [30, 20, 10]
    assert (shown[:, :, :2] == 114).all()


def test_many_canonical_poses_are_those_of_each_alone():
    for name in (ASSET, "hand-screw-clamp"):
        parts = find_asset(name).tracked_parts
        classes = [TrainClass(part.name, 0, part.mesh.vertices[:5]) for part in parts]
        shapes = part_shapes(find_asset(name), classes)
        rng = np.random.default_rng(4)
        kinds = np.repeat(np.arange(len(parts)), 40)
        poses = [
            Pose.exp([*rng.normal(0, 2, 3), *rng.uniform((-0.3, -0.2, 0.4), (0.3, 0.2, 1.0))])
            for _ in kinds
        ]
        matrices = torch.tensor(np.stack([pose.matrix for pose in poses]), dtype=torch.float32)
        rotations, translations = canonical(
            matrices[:, :3, :3],
            matrices[:, :3, 3],
            torch.from_numpy(kinds),
            shape_table(list(shapes.values())),
        )
        for i, pose in enumerate(poses):
            wanted = canonical_pose(pose, parts[kinds[i]].symmetry)
            assert np.abs(rotations[i].numpy() - wanted.rotation).max() < 2e-4
            assert np.abs(translations[i].numpy() - wanted.translation).max() < 1e-5


def test_a_rolled_camera_gives_a_symmetric_part_its_canonical_pose(images, shapes, table):
    """The labels of a rolled view are those of the same part seen by a camera that is rolled."""
    views = turned_views(table)
    found = labelled(views, table, shape_table(list(shapes.values())))
    moved = checked = 0
    for k in range(len(views)):
        labels = images[int(views.images[k])].labels
        roll = Pose.exp([0, 0, float(views.rolls[k]), 0, 0, 0])
        for j, each in enumerate(labels.instances):
            if found.classes[k, j] < 0:
                continue
            shape = shapes[each.part]
            assert found.classes[k, j] == shape.number
            rolled = roll @ each.camera_from_body
            canonical_one = canonical_pose(rolled, shape.symmetry)
            # Pixels of the image are those of the camera as it was.
            points = (roll.inverse() @ canonical_one).transform(shape.keypoints_m)
            expected = places(views, k, labels.camera.project(points))
            assert np.abs(found.keypoints[k, j, :, :2].numpy() - expected).max() < 0.02
            moved += canonical_one.angle_to(rolled) > 0.01
            checked += 1
    assert checked > 10
    assert moved > 0


def test_a_turned_picture_and_its_boxes_agree(images, shapes, table):
    """The box is where the part is seen in the image, by its mask, and no larger than needed."""
    views = turned_views(table)
    found = labelled(views, table, shape_table(list(shapes.values())))
    checked = 0
    for k in range(len(views)):
        labels = images[int(views.images[k])].labels
        for j, each in enumerate(labels.instances):
            rows, columns = np.nonzero(each.mask(labels.camera))
            seen = places(views, k, np.column_stack([columns, rows]).astype(float))
            inside = seen[((seen > 0) & (seen < (384, 256))).all(axis=1)]
            if len(inside) == 0:
                continue
            box = found.boxes[k, j].numpy()
            assert (inside.min(axis=0) > box[:2] - 1.5).all()
            assert (inside.max(axis=0) < box[2:] + 1.5).all()
            if each.visibility > 0.99 and len(inside) == len(seen):
                assert np.abs(inside.min(axis=0) - box[:2]).max() < 2.5
                assert np.abs(inside.max(axis=0) - box[2:]).max() < 2.5
                checked += 1
    assert checked > 3


def test_tiles_fill_a_view_and_show_a_part_each(images, shapes):
    parameters = ViewParameters(tiled_share=1.0, tiles=(2, 3))
    course = Course([(list(images)[:3], shapes)], parameters, 1, CPU)
    ((pictures, found),) = course.batches(1, range(1))
    assert pictures.shape == (1, 3, 256, 384)
    assert pictures.dtype == torch.uint8
    boxes = found.boxes[0][found.classes[0] >= 0].numpy()
    middles = (boxes[:, :2] + boxes[:, 2:]) / 2
    assert len({(int(x // 128), int(y // 128)) for x, y in middles}) == 6
    # No box reaches from one tile into the next.
    assert (boxes[:, 0] // 128 == (boxes[:, 2] - 1e-3) // 128).all()


def test_the_same_seed_gives_the_same_views(images, shapes):
    group = [(list(images), shapes)]
    first, again, other = (
        next(Course(group, ViewParameters(), seed, CPU).batches(3, range(1))) for seed in (5, 5, 6)
    )
    assert torch.equal(first[0], again[0])
    assert torch.equal(first[1].keypoints, again[1].keypoints)
    assert not torch.equal(first[0], other[0])


def test_a_round_shows_every_image_once(images, shapes):
    course = Course([(list(images), shapes)], ViewParameters(), 2, CPU)
    shown = [place for number in range(4) for place in course.places(number, 1)]
    assert sorted(shown) == list(range(8))
    assert shown != list(range(8))


def test_a_whole_image_keeps_its_labels(images, shapes):
    parameters = ViewParameters(height_px=288, width_px=480)
    batches = list(whole_batches([(list(images), shapes)], parameters, 3, CPU))
    assert [len(pictures) for pictures, _ in batches] == [3, 3, 2]
    samples = iter(images)
    for pictures, found in batches:
        assert pictures.shape[1:] == (3, 288, 480)
        for k in range(len(pictures)):
            sample = next(samples)
            instances = sample.labels.instances
            given = np.stack([each.keypoints for each in instances])
            keypoints = found.keypoints[k, : len(instances)].numpy()
            # 480x270 in 480x288: nine rows of grey above, and edges at 0 in place of middles.
            np.testing.assert_allclose(
                keypoints[..., :2], given[..., :2] + np.array([0.5, 9.5]), atol=0.03
            )
            assert (keypoints[..., 2][given[..., 2] > 0] == 1).all()
            hidden = [each.visibility < 0.1 or each.n_seen < 40 for each in instances]
            assert found.is_ignored[k, : len(instances)][torch.tensor(hidden)].all()
            middle = pictures[k, :, 9:-9].numpy().transpose(1, 2, 0)[..., ::-1]
            np.testing.assert_array_equal(middle, sample.image())


def test_light_changes_and_nothing_is_mirrored(table):
    generator = torch.Generator().manual_seed(0)
    ramp = torch.arange(64, dtype=torch.float32).mul(4).expand(20, 3, 32, 64)
    lit = relit(ramp, ViewParameters(), generator)
    assert (lit.diff(dim=-1) >= 0).all()
    assert lit.min() >= 0
    assert lit.max() <= 255
    views = turned_views(table, 40)
    assert (torch.linalg.det(views.matrices[:, :, :2]) > 0).all()


def test_images_are_the_same_held_or_read(images):
    samples = list(images)
    memory, rows = HeldPictures(samples, CPU).take([5, 2, 5])
    held = memory[rows]
    memory, rows = ReadPictures(samples, CPU).take([5, 2, 5])
    assert len(memory) == 2
    assert torch.equal(held, memory[rows])


def test_an_image_that_is_gone_is_named(images, tmp_path):
    gone = replace(images[0], path=tmp_path / "gone.jpg")
    with pytest.raises(DatasetError, match=r"gone\.jpg"):
        ReadPictures([gone], CPU).take([0])


def test_targets_of_several_sets_are_filled_up():
    def targets(classes):
        classes = torch.tensor(classes)
        boxes = classes[..., None].expand(*classes.shape, 4).float()
        points = torch.zeros(*classes.shape, 4, 3)
        return Targets(classes, boxes, points, torch.zeros(classes.shape, dtype=torch.bool))

    both = joined([targets([[-1, 3, -1, 5]]), targets([[7], [-1]])])
    assert both.classes.tolist() == [[3, 5], [7, -1], [-1, -1]]
    assert both.boxes[0, :, 0].tolist() == [3, 5]
    assert both.keypoints.shape == (3, 2, 4, 3)


def test_images_of_two_sizes_are_refused(images, shapes):
    labels = images[0].labels
    camera = replace(labels.camera, width=100)
    other = replace(images[0], labels=replace(labels, camera=camera))
    with pytest.raises(DatasetError, match="of one size"):
        label_table([([images[0], other], shapes)])
    with pytest.raises(DatasetError, match="none"):
        label_table([([], shapes)])


def test_a_part_that_the_asset_has_not_is_refused():
    strange = TrainClass("lid", 0, np.zeros((4, 3)))
    with pytest.raises(DatasetError, match="no part 'lid'"):
        part_shapes(find_asset(ASSET), [strange])
