"""Files that are no detector: each is refused with what is wrong and what to do."""

from types import SimpleNamespace

import numpy as np
import pytest
from fake_network import INPUT, card, output, write_detector, write_network

from snapfit.models.detector.card import CARD_NAME, ONNX_NAME, read_card
from snapfit.models.errors import DetectorError
from snapfit.tracking.detection.onnx_model import OnnxModel
from snapfit.tracking.errors import TrackingError


def load(folder, **options):
    return OnnxModel(folder / ONNX_NAME, card(), **options)


def test_a_fitting_file_runs(tmp_path):
    model = load(write_detector(tmp_path))
    assert model.input_size == INPUT
    assert model.provider == "CPUExecutionProvider"
    rows = model.run(np.zeros((1, 3, INPUT[1], INPUT[0]), dtype=np.float32))
    np.testing.assert_array_equal(rows, output()[0])


def test_a_missing_file(tmp_path):
    with pytest.raises(DetectorError, match=r"detector\.onnx: is missing: snapfit train"):
        load(tmp_path)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 a zip", b"\x00" * 400, b"x = 3\n"])
def test_a_file_that_is_no_onnx(tmp_path, content):
    (tmp_path / ONNX_NAME).write_bytes(content)
    with pytest.raises(DetectorError, match=r"detector\.onnx: .*(ONNX|takes)"):
        load(tmp_path)


def test_a_truncated_file(tmp_path):
    write_network(tmp_path, output())
    whole = (tmp_path / ONNX_NAME).read_bytes()
    (tmp_path / ONNX_NAME).write_bytes(whole[: len(whole) // 2])
    with pytest.raises(DetectorError, match=r"detector\.onnx"):
        load(tmp_path)


def test_another_number_of_classes(tmp_path):
    write_network(tmp_path, np.zeros((1, 4 + 5 + 51, 60)))
    with pytest.raises(DetectorError, match="it would have 5 classes"):
        load(tmp_path)


def test_fewer_rows_than_the_keypoints_alone_need(tmp_path):
    write_network(tmp_path, np.zeros((1, 30, 60)))
    with pytest.raises(DetectorError, match="own training set"):
        load(tmp_path)


def test_an_end_to_end_export(tmp_path):
    write_network(tmp_path, np.zeros((1, 300, 6 + 51)))
    with pytest.raises(DetectorError, match="without NMS"):
        load(tmp_path)


def test_a_classifier(tmp_path):
    write_network(tmp_path, np.zeros((1, 1000)))
    with pytest.raises(DetectorError, match="is it a pose network"):
        load(tmp_path)


def test_an_input_that_is_no_image(tmp_path):
    write_network(tmp_path, output(), input_shape=(1, 16))
    with pytest.raises(DetectorError, match="one image"):
        load(tmp_path)


def test_rows_that_only_running_shows(tmp_path):
    """The file states no shape."""
    write_network(tmp_path, output(), free=True)
    model = load(tmp_path)
    assert model.input_size is None

    model._session = SimpleNamespace(run=lambda _, __: [np.zeros((1, 60, 60), np.float32)])
    with pytest.raises(DetectorError, match="5 classes"):
        model.run(np.zeros((1, 3, 64, 64), dtype=np.float32))


def test_an_input_of_another_size_than_the_file_fixes(tmp_path):
    model = load(write_detector(tmp_path))
    with pytest.raises(DetectorError, match="does not run"):
        model.run(np.zeros((1, 3, 64, 64), dtype=np.float32))


def test_a_provider_that_is_not_there(tmp_path):
    folder = write_detector(tmp_path)
    with pytest.raises(TrackingError, match=r"has no NoSuchProvider here; it has .*CPU"):
        load(folder, providers=("NoSuchProvider",))
    assert load(folder, providers=("NoSuchProvider", "CPUExecutionProvider")).provider


def test_a_card_is_read_back(tmp_path):
    write_detector(tmp_path)
    found = read_card(tmp_path / CARD_NAME)
    assert found.model_copy(update={"classes": ()}) == card().model_copy(update={"classes": ()})
    for each, given in zip(found.classes, card().classes, strict=True):
        assert each.part == given.part
        np.testing.assert_allclose(each.points, given.points, atol=6e-8)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("", "is missing"),
        ("{", "cannot be read"),
        ('{"asset": "x"}', "classes"),
        ('"input_width_px": 321', "input_width_px"),
        ('"colour": 1', "colour"),
    ],
)
def test_a_damaged_card_says_which_key(tmp_path, change, message):
    write_detector(tmp_path)
    path = tmp_path / CARD_NAME
    if not change:
        path.unlink()
    elif change.startswith("{"):
        path.write_text(change)
    elif "width" in change:
        path.write_text(path.read_text().replace('"input_width_px": 320', change))
    else:
        path.write_text(path.read_text().replace('"asset"', f'{change}, "asset"', 1))
    with pytest.raises(DetectorError, match=message):
        read_card(path)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda classes: [classes[0], classes[0]], "one class"),
        (lambda classes: [classes[0].model_copy(update={"keypoints_m": POINTS})], "at least"),
    ],
)
def test_classes_that_cannot_be(edit, message):
    classes = [each.model_dump() if hasattr(each, "model_dump") else each for each in edit_of(edit)]
    with pytest.raises(ValueError, match=message):
        card(classes=classes)


POINTS = ((0.0, 0.0, 0.0),) * 3


def edit_of(edit):
    return edit(list(card().classes))


def test_classes_with_unlike_numbers_of_keypoints():
    first, second = (each.model_dump() for each in card().classes)
    second["keypoints_m"] = second["keypoints_m"][:5]
    with pytest.raises(ValueError, match="as many keypoints"):
        card(classes=[first, second])
