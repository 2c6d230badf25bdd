"""Small pictures of a dataset: the frames that show a condition, and what is missing is told."""

import json

import cv2
import numpy as np
import pytest

from snapfit.models.errors import DatasetError
from snapfit.models.pose import Pose
from snapfit.models.workbench.pictures import main, shown_frame, small_pictures
from snapfit.models.workbench.split import TEST_FRAMES, Condition

N = 50


def write_scene(scene, n):
    (scene / "rgb").mkdir(parents=True)
    (scene / ".frames").mkdir()
    x_m = 0.0
    for i in range(n):
        x_m += 0.02 if i == 26 else 0.002
        entry = {
            "poses": {"jaw": Pose.from_translation(x_m, 0, 0.5).matrix.tolist()},
            "visib": {"jaw": 0.6 if i in (20, 25) else 0.1},
            "in_hand": "jaw",
        }
        (scene / ".frames" / f"{i:06d}.json").write_text(json.dumps(entry))
        image = np.full((72, 128, 3), 5 * i, np.uint8)
        cv2.imwrite(str(scene / "rgb" / f"{i:06d}.jpg"), image)


def test_the_frame_is_one_that_shows_the_condition(tmp_path):
    write_scene(tmp_path, N)
    assert shown_frame(tmp_path, Condition.NORMAL) == 1
    assert shown_frame(tmp_path, Condition.DYNAMIC) == 48
    assert shown_frame(tmp_path, Condition.BLUR) == 26
    assert shown_frame(tmp_path, Condition.HAND) == 20
    assert shown_frame(tmp_path, Condition.ALL) == 36


def test_each_scene_has_a_small_picture(tmp_path):
    for name in TEST_FRAMES:
        for condition in Condition:
            write_scene(tmp_path / name / "test" / condition, 5)
    made = small_pictures(tmp_path, tmp_path / "out")
    assert len(made) == 25
    for path in made:
        assert cv2.imread(str(path)).shape == (270, 480, 3)


def test_what_is_missing_is_told(tmp_path):
    with pytest.raises(DatasetError, match="no finished frame"):
        small_pictures(tmp_path, tmp_path / "out")
    scene = tmp_path / next(iter(TEST_FRAMES)) / "test" / "normal"
    write_scene(scene, 3)
    (scene / "rgb" / "000000.jpg").unlink()
    with pytest.raises(DatasetError, match=r"000000\.jpg.*render the dataset first"):
        small_pictures(tmp_path, tmp_path / "out")
    (scene / ".frames" / "000001.json").write_text("{")
    with pytest.raises(SystemExit, match=r"000000\.jpg"):
        main([str(tmp_path), str(tmp_path / "out")])
    with pytest.raises(SystemExit, match="usage"):
        main([])
