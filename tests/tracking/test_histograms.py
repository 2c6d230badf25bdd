"""The colour histograms of several bodies: their own, or one pair for all."""

from collections.abc import Sequence

import numpy as np
import pytest
from scenes import CAMERA, Array, bodies_at, both_cameras, counted_models, images_of

from snapfit.models.pose import Pose
from snapfit.tracking.color_histograms import N_COLORS, ColorHistograms
from snapfit.tracking.kernels.types import Bodies, Lines
from snapfit.tracking.parameters import HistogramParameters
from snapfit.tracking.region_modality import empty_lines

GROUND_BGR, LEFT_BGR, RIGHT_BGR, NEW_BGR = (20, 20, 20), (200, 0, 0), (0, 0, 200), (0, 200, 0)
DEPTH_M = 0.5
N_LINES = 10


def bin_of(bgr: tuple[int, int, int]) -> int:
    b, g, r = (value // 16 for value in bgr)
    return 256 * b + 16 * g + r


def scene(left: tuple[int, int, int] = LEFT_BGR, right: tuple[int, int, int] = RIGHT_BGR) -> Array:
    """A board of one colour left and of another right, before dark ground."""
    color = np.full((CAMERA.height, CAMERA.width, 3), GROUND_BGR, dtype=np.uint8)
    color[50:150, 20:70], color[50:150, 160:210] = left, right
    return color


def lines_at_right_edges() -> Lines:
    """Lines across the right edge of each board, 30 px long on both sides; body frame z = 0."""
    lines = empty_lines(2, N_LINES)
    for body, edge_u in enumerate((69.5, 209.5)):
        v = np.linspace(60, 140, N_LINES)
        lines.point[body, :, 0] = (edge_u - CAMERA.cx) / CAMERA.fx * DEPTH_M
        lines.point[body, :, 1] = (v - CAMERA.cy) / CAMERA.fy * DEPTH_M
        lines.place[body, :, 2] = 1
        lines.place[body, :, 6:8] = 30
    lines.valid[:] = 1
    return lines


class Learner:
    """Histograms of two bodies that stand still."""

    def __init__(self, parameters: HistogramParameters | None = None) -> None:
        self.histograms = ColorHistograms(2, parameters or HistogramParameters())
        self.bodies: Bodies = bodies_at([Pose.from_translation(0, 0, DEPTH_M)] * 2)
        self.lines = lines_at_right_edges()

    def learn(
        self,
        color: Array,
        which: Sequence[int] = (1, 1),
        afresh_beyond_px: float | None = None,
    ) -> None:
        self.histograms.learn(
            images_of(color, n_bodies=2),
            both_cameras(),
            counted_models([N_LINES, N_LINES], [1, 1]),
            self.bodies,
            self.lines,
            np.array(which),
            afresh_beyond_px=afresh_beyond_px,
        )

    def table(self, body: int, bgr: tuple[int, int, int]) -> float:
        """Posterior of a body's foreground for a colour."""
        return float(self.bodies.tables[body, bin_of(bgr)])

    def share(self, pair: int, side: int, bgr: tuple[int, int, int]) -> float:
        """Share of a colour in a histogram; side 0 is the foreground."""
        return float(self.histograms.histograms[pair, side, bin_of(bgr)])


def test_the_first_colours_are_those_beside_the_contours() -> None:
    learner = Learner()
    learner.learn(scene(), afresh_beyond_px=1.0)
    for body, (own, other) in enumerate(((LEFT_BGR, RIGHT_BGR), (RIGHT_BGR, LEFT_BGR))):
        assert learner.share(body, 0, own) == pytest.approx(1)
        assert learner.share(body, 1, GROUND_BGR) == pytest.approx(1)
        assert learner.table(body, own) == 1
        assert learner.table(body, GROUND_BGR) == 0
        # What was never seen on either side says nothing.
        assert learner.table(body, other) == 0.5


def test_each_pair_of_own_histograms_sums_to_one() -> None:
    learner = Learner()
    learner.learn(scene(), afresh_beyond_px=1.0)
    assert learner.histograms.histograms.shape == (2, 2, N_COLORS)
    assert np.allclose(learner.histograms.histograms.sum(axis=2), 1, atol=1e-5)


def test_bodies_may_share_one_pair() -> None:
    learner = Learner(HistogramParameters(shared=True))
    learner.learn(scene(), afresh_beyond_px=1.0)
    assert learner.histograms.histograms.shape == (1, 2, N_COLORS)
    assert learner.share(0, 0, LEFT_BGR) == pytest.approx(0.5, abs=0.02)
    assert learner.share(0, 0, RIGHT_BGR) == pytest.approx(0.5, abs=0.02)
    assert np.array_equal(*learner.bodies.tables)
    assert learner.table(0, RIGHT_BGR) == learner.table(1, LEFT_BGR) == 1


def test_new_colours_are_blended_in_at_their_rates() -> None:
    learner = Learner(HistogramParameters(foreground_rate=0.3, background_rate=0.1))
    learner.learn(scene(), afresh_beyond_px=1.0)
    changed = scene(left=NEW_BGR)
    changed[50:150, 70:110] = NEW_BGR
    learner.learn(changed)
    assert learner.share(0, 0, NEW_BGR) == pytest.approx(0.3, abs=1e-5)
    assert learner.share(0, 0, LEFT_BGR) == pytest.approx(0.7, abs=1e-5)
    assert learner.share(0, 1, NEW_BGR) == pytest.approx(0.1, abs=1e-5)
    assert learner.table(0, NEW_BGR) == pytest.approx(0.75, abs=1e-4)
    assert learner.share(1, 0, RIGHT_BGR) == pytest.approx(1)


@pytest.mark.parametrize("shared", [False, True])
def test_a_body_that_is_not_believed_teaches_nothing(shared: bool) -> None:
    learner = Learner(HistogramParameters(shared=shared))
    learner.learn(scene(), afresh_beyond_px=1.0)
    before = learner.histograms.histograms.copy()
    learner.learn(scene(NEW_BGR, NEW_BGR), which=(0, 0))
    assert np.array_equal(learner.histograms.histograms, before)
    learner.learn(scene(NEW_BGR, RIGHT_BGR), which=(0, 1))
    assert learner.share(0, 0, NEW_BGR) == 0


def test_learning_afresh_forgets_what_was_learned() -> None:
    learner = Learner()
    learner.learn(scene(), afresh_beyond_px=1.0)
    learner.learn(scene(NEW_BGR, RIGHT_BGR), which=(1, 0), afresh_beyond_px=1.0)
    assert learner.share(0, 0, LEFT_BGR) == 0
    assert learner.share(0, 0, NEW_BGR) == pytest.approx(1)
    assert learner.share(1, 0, RIGHT_BGR) == pytest.approx(1)


@pytest.mark.parametrize(("margin_px", "clean"), [(None, False), (1.0, False), (5.0, True)])
def test_what_lies_near_the_contour_is_left_out_while_the_pose_may_be_off(
    margin_px: float | None, clean: bool
) -> None:
    learner = Learner(HistogramParameters(foreground_rate=1, background_rate=1))
    color = scene()
    color[50:150, 66:74] = NEW_BGR
    learner.learn(color, afresh_beyond_px=margin_px)
    assert (learner.share(0, 0, NEW_BGR) == 0) == clean
    assert (learner.share(0, 1, NEW_BGR) == 0) == clean


def test_lines_that_took_no_part_and_inactive_bodies_are_not_sampled() -> None:
    learner = Learner()
    learner.lines.valid[0, 5:] = 0
    color = scene()
    color[102:] = NEW_BGR
    learner.learn(color, afresh_beyond_px=1.0)
    assert learner.share(0, 0, NEW_BGR) == 0
    assert learner.share(1, 0, NEW_BGR) > 0.3
    learner.bodies.active[0] = 0
    before = learner.histograms.histograms[0].copy()
    learner.learn(scene(NEW_BGR, NEW_BGR))
    assert np.array_equal(learner.histograms.histograms[0], before)
