"""Training: a few images are learnt by heart, a run goes on where it was stopped, files fit."""

import json

import cv2
import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="PyTorch is not installed: snapfit[train]")
pytest.importorskip("onnx", reason="onnx is not installed: snapfit[train]")

from snapfit.models.asset import find_asset
from snapfit.models.detector.batches import Course, whole_batches
from snapfit.models.detector.card import CARD_NAME, INT8_NAME, ONNX_NAME, read_card
from snapfit.models.detector.curves import smoothed, write_curves
from snapfit.models.detector.device import Workplace, workplace
from snapfit.models.detector.metrics import validated
from snapfit.models.detector.recipe import Recipe
from snapfit.models.detector.shapes import part_shapes
from snapfit.models.detector.size import NetworkSize
from snapfit.models.detector.train import (
    CHECKPOINT_NAME,
    CURVES_NAME,
    train_detector,
    train_shared,
)
from snapfit.models.detector.trainer import (
    Trainer,
    rate_at,
    read_checkpoint,
    settle_statistics,
    write_checkpoint,
)
from snapfit.models.detector.views import ViewParameters
from snapfit.models.errors import DatasetError, PictureError, TrainingError
from snapfit.models.train_reader import TrainSet
from snapfit.models.workbench.train_set import TrainOrder, render_train_set

ASSET = "hobby-corner-clamp"
SMALL = NetworkSize(
    width=0.125, most_channels=512, box_channels=16, class_channels=16, keypoint_channels=32
)
VIEWS = ViewParameters(across_px=288, height_px=96, width_px=160, tiles=(1, 2), roll_deg=5)
RECIPE = Recipe(size=SMALL, views=VIEWS, input_height_px=160, input_width_px=288, steps=4, batch=2)
PLACE = Workplace(torch.device("cpu"), "a CPU", False, 1)


@pytest.fixture(scope="module")
def images(tmp_path_factory):
    """40 images, of which two are kept for validation."""
    folder = tmp_path_factory.mktemp("images")
    render_train_set(TrainOrder(folder, (ASSET,), count=40, seed=3, scale=0.4), jobs=1)
    return TrainSet(folder / ASSET)


@pytest.fixture(scope="module")
def asset():
    return find_asset(ASSET)


@pytest.mark.slow
def test_a_few_images_are_learnt_by_heart(images, asset):
    """All parts found, boxes nearly exact, keypoints within a pixel: losses and decoding agree."""
    shapes = part_shapes(asset, images.classes)
    recipe = Recipe(
        size=SMALL, views=VIEWS, input_height_px=256, input_width_px=448, steps=250, batch=4
    )
    trainer = Trainer(recipe, len(shapes), 17, PLACE)
    batches = list(whole_batches([(list(images)[:4], shapes)], recipe.whole, 4, PLACE))
    first = trainer.learn(*batches[0])["total"]
    for _ in range(recipe.steps - 1):
        last = trainer.learn(*batches[0])["total"]
    assert last < 0.15 * first
    settle_statistics(trainer.averaged, batches, PLACE)
    found = validated(trainer.averaged, batches, PLACE.device)
    assert found.recall == 1
    assert found.precision > 0.9
    assert found.overlap > 0.95
    assert found.keypoint_error_px < 1.5


def test_a_run_that_is_stopped_goes_on_to_the_same_end(images, asset, tmp_path):
    card = train_detector(asset, images, RECIPE, tmp_path / "whole", PLACE)
    shapes = part_shapes(asset, images.classes)
    samples = images.selected(validation=False)
    trainer = Trainer(RECIPE, len(shapes), 17, PLACE)
    course = Course([(samples, shapes)], VIEWS, RECIPE.seed, PLACE)
    for batch in course.batches(2, range(2)):
        trainer.learn(*batch)
    write_checkpoint(trainer, tmp_path / "parted" / CHECKPOINT_NAME)
    steps = []
    train_detector(
        asset,
        images,
        RECIPE,
        tmp_path / "parted",
        PLACE,
        progress=lambda report: steps.append(report.step),
    )
    assert steps == [3, 4]
    whole, parted = (
        read_checkpoint(tmp_path / name / CHECKPOINT_NAME) for name in ("whole", "parted")
    )
    for name, tensor in whole["averaged"].items():
        assert torch.allclose(tensor.float(), parted["averaged"][name].float(), atol=1e-5), name
    assert whole["history"]["total"] == pytest.approx(parted["history"]["total"], rel=1e-4)
    assert card.training["views"] == 8


def test_the_files_of_a_bundle(images, asset, tmp_path):
    seen = []
    card = train_detector(
        asset, images, RECIPE, tmp_path, PLACE, is_int8=True, progress=seen.append
    )
    assert [report.step for report in seen] == [1, 2, 3, 4]
    assert seen[-1].share == 1
    assert (tmp_path / ONNX_NAME).stat().st_size < 12e6
    assert (tmp_path / INT8_NAME).is_file()
    assert cv2.imread(str(tmp_path / CURVES_NAME)).shape == (540, 960, 3)
    read = read_card(tmp_path / CARD_NAME)
    assert read.training == json.loads(json.dumps(card.training))
    assert [each.part for each in read.classes] == [each.part for each in images.classes]
    for each, given in zip(read.classes, images.classes, strict=True):
        np.testing.assert_allclose(each.points, given.keypoints_m, atol=1e-6)
    assert read.training["images"] == 38
    assert read.training["images_with_joined_parts"] is True
    assert read.metrics["images"] == 2
    assert read.opset == 17
    again = train_detector(asset, images, RECIPE, tmp_path, PLACE, progress=seen.append)
    assert len(seen) == 4
    assert again.metrics == card.metrics


def test_without_joined_parts_half_of_the_images_are_left(images, asset, tmp_path):
    recipe = Recipe(
        size=SMALL,
        views=VIEWS,
        input_height_px=160,
        input_width_px=288,
        steps=1,
        batch=2,
        assembled=False,
    )
    card = train_detector(asset, images, recipe, tmp_path, PLACE)
    assert card.training["images"] == 19
    assert card.training["images_with_joined_parts"] is False


def test_a_time_limit_ends_it(images, asset, tmp_path):
    recipe = Recipe(
        size=SMALL,
        views=VIEWS,
        input_height_px=160,
        input_width_px=288,
        steps=10_000,
        batch=2,
        minutes=1e-4,
    )
    card = train_detector(asset, images, recipe, tmp_path, PLACE)
    assert card.training["views"] == 2


def test_another_recipe_is_no_going_on(images, asset, tmp_path):
    train_detector(asset, images, RECIPE, tmp_path, PLACE)
    other = Recipe(
        size=SMALL, views=VIEWS, input_height_px=160, input_width_px=288, steps=4, batch=3
    )
    with pytest.raises(TrainingError, match="another recipe"):
        train_detector(asset, images, other, tmp_path, PLACE)
    with pytest.raises(TrainingError, match="another classes"):
        Trainer(RECIPE, 5, 17, PLACE).resume(tmp_path / CHECKPOINT_NAME)


def test_weights_of_another_asset_are_taken_over_where_they_fit(tmp_path):
    given = Trainer(RECIPE, 3, 17, PLACE)
    write_checkpoint(given, tmp_path / "a.pt")
    mine = Trainer(Recipe(size=SMALL, seed=7), 5, 17, PLACE)
    taken = mine.begin_from(tmp_path / "a.pt")
    state = given.averaged.state_dict()
    # All but the layers that tell classes apart: one in each of three heads, weight and bias.
    assert taken == len(state) - 2 * 3
    assert torch.equal(mine.network.stem[0].conv.weight, given.averaged.stem[0].conv.weight)
    assert mine.network.class_heads[0][-1].weight.shape[0] == 5
    wider = Trainer(Recipe(size=NetworkSize(width=0.3, keypoint_channels=33)), 3, 9, PLACE)
    assert wider.begin_from(tmp_path / "a.pt") < len(state)


@pytest.mark.parametrize("content", [b"", b"nothing of use", b"PK\x03\x04"])
def test_a_file_that_is_no_checkpoint(tmp_path, content):
    (tmp_path / "c.pt").write_bytes(content)
    with pytest.raises(TrainingError, match="no checkpoint"):
        read_checkpoint(tmp_path / "c.pt")
    with pytest.raises(TrainingError, match="no checkpoint"):
        read_checkpoint(tmp_path / "missing.pt")
    torch.save({"format": 99}, tmp_path / "old.pt")
    with pytest.raises(TrainingError, match="this version"):
        read_checkpoint(tmp_path / "old.pt")


def test_a_loss_that_is_no_number_stops_the_training(images, asset):
    shapes = part_shapes(asset, images.classes)
    trainer = Trainer(RECIPE, len(shapes), 17, PLACE)
    torch.nn.init.constant_(trainer.network.class_heads[0][-1].bias, float("nan"))
    pictures, targets = next(whole_batches([(list(images)[:2], shapes)], RECIPE.whole, 2, PLACE))
    with pytest.raises(TrainingError, match="lower the learning rate"):
        trainer.learn(pictures, targets)


def test_a_device_that_is_not_there():
    with pytest.raises(TrainingError, match="no device 'cuda:77'"):
        workplace("cuda:77")
    with pytest.raises(TrainingError, match="no device 'abacus'"):
        workplace("abacus")
    assert workplace("cpu").device.type == "cpu"


@pytest.mark.parametrize(
    "change", [{"steps": 0}, {"batch": -1}, {"input_width_px": 650}, {"learning_rate": 0.0}]
)
def test_a_recipe_that_cannot_be(change):
    with pytest.raises(ValueError, match=r"of a training is positive|multiple of 32"):
        Recipe(**change)


def test_images_that_are_all_kept_for_validation(images, asset, tmp_path):
    few = TrainSet(images._samples[0].path.parents[3])
    few._samples = images.selected(validation=True)
    with pytest.raises(DatasetError, match="no training image is left"):
        train_detector(asset, few, RECIPE, tmp_path, PLACE)


def test_the_learning_rate_rises_and_falls():
    rates = [rate_at(share, RECIPE) for share in np.linspace(0, 1, 101)]
    assert int(np.argmax(rates)) == 5
    assert max(rates) == pytest.approx(1)
    assert rates[-1] == pytest.approx(RECIPE.final_rate)
    assert min(rates) > 0
    assert (np.diff(rates[5:]) < 0).all()


def test_batches_are_the_same_wherever_a_run_goes_on(images, asset):
    shapes = part_shapes(asset, images.classes)
    course = Course([(images.selected(validation=False), shapes)], VIEWS, 5, PLACE)
    whole = list(course.batches(2, range(3)))
    (again,) = course.batches(2, range(2, 3))
    assert torch.equal(whole[2][0], again[0])
    assert torch.equal(whole[2][1].keypoints, again[1].keypoints)
    assert not torch.equal(whole[1][0], whole[2][0])


def test_a_network_for_several_assets_is_one_to_begin_from(images, asset, tmp_path):
    train_shared([(asset, images), (asset, images)], RECIPE, tmp_path / "shared", PLACE)
    state = read_checkpoint(tmp_path / "shared" / CHECKPOINT_NAME)
    assert state["classes"] == 2 * len(images.classes)
    assert cv2.imread(str(tmp_path / "shared" / CURVES_NAME)) is not None
    assert not (tmp_path / "shared" / ONNX_NAME).exists()
    card = train_detector(
        asset,
        images,
        RECIPE,
        tmp_path / "own",
        PLACE,
        begin_from=tmp_path / "shared" / CHECKPOINT_NAME,
    )
    assert card.training["began_from"] == CHECKPOINT_NAME


def test_curves_are_drawn_and_smoothed(tmp_path):
    assert smoothed([1.0, 3.0, 2.0]).tolist() == [1, 3, 2]
    assert len(smoothed(list(np.ones(1000)))) == 991
    write_curves({"total": [9.0, 5.0, 3.0, 2.0]}, tmp_path / "a.png")
    picture = cv2.imread(str(tmp_path / "a.png"))
    assert (picture < 200).any()
    write_curves({}, tmp_path / "empty.png")
    assert (cv2.imread(str(tmp_path / "empty.png")) == 255).all()
    (tmp_path / "taken.png").mkdir()
    with pytest.raises(PictureError, match="cannot be written"):
        write_curves({}, tmp_path / "taken.png")
