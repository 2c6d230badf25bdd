"""A step that can be recorded as a CUDA graph: it asks for no value and copies nothing in.

There is no GPU where the tests run. What breaks a recording can be seen on any device: the
operations that read a value, whose result's size depends on values, or that bring in numbers from
outside.
"""

import pytest

torch = pytest.importorskip("torch", reason="PyTorch is not installed: snapfit[train]")

from torch.utils._python_dispatch import TorchDispatchMode

from snapfit.models.asset import find_asset
from snapfit.models.detector.batches import Course
from snapfit.models.detector.device import CPU
from snapfit.models.detector.graphed import MOST_PARTS
from snapfit.models.detector.recipe import Recipe
from snapfit.models.detector.shapes import part_shapes
from snapfit.models.detector.size import NetworkSize
from snapfit.models.detector.trainer import Trainer
from snapfit.models.detector.views import ViewParameters
from snapfit.models.train_reader import TrainSet
from snapfit.models.workbench.train_set import TrainOrder, render_train_set

ASSET = "hobby-corner-clamp"
SMALL = NetworkSize(
    width=0.125, most_channels=512, box_channels=16, class_channels=16, keypoint_channels=32
)
VIEWS = ViewParameters(across_px=288, height_px=96, width_px=160, tiles=(1, 2), roll_deg=5)
RECIPE = Recipe(size=SMALL, views=VIEWS, steps=4, batch=3)
FORBIDDEN = {
    "_local_scalar_dense": "reads a value",
    "nonzero": "its size depends on values",
    "masked_select": "its size depends on values",
    "unique_consecutive": "its size depends on values",
    "_unique2": "its size depends on values",
    "lift_fresh": "brings in numbers",
    # Its gradient does; on a CPU under a dispatch mode PyTorch takes another formula.
    "prod": "reads a value",
    "linalg_inv_ex": "waits to see whether it succeeded",
}


class Recording(TorchDispatchMode):
    """Refuses what a CUDA graph cannot hold."""

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):
        name = func.name().split("::")[1].split(".")[0]
        assert name not in FORBIDDEN, f"{name} {FORBIDDEN[name]}"
        if name in ("index", "index_put_"):
            assert all(i is None or i.dtype != torch.bool for i in args[1]), "a mask selects"
        return func(*args, **(kwargs or {}))


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    folder = tmp_path_factory.mktemp("images")
    render_train_set(TrainOrder(folder, (ASSET,), count=4, seed=3, scale=0.4), jobs=1)
    images = TrainSet(folder / ASSET)
    return Course([(list(images), part_shapes(find_asset(ASSET), images.classes))], VIEWS, 1, CPU)


@pytest.fixture
def drawn(course):
    """A batch as the graph draws it."""
    places = course.places(0, RECIPE.batch)
    memory, rows = course._pictures.take(places)
    return memory, rows, torch.tensor(places), course.seeded(torch.Generator(), 0)


def test_a_step_can_be_recorded(course, drawn):
    trainer = Trainer(RECIPE, 3, 17, CPU)
    trainer.learn(*course.drawn(*drawn, MOST_PARTS))
    trainer.prepare()
    # The optimiser on a GPU is PyTorch's own, made for it.
    trainer.optimiser.step = lambda: None
    with Recording():
        found = trainer.advance(*course.drawn(*drawn, MOST_PARTS))
    assert found.shape == (5,)
    assert torch.isfinite(found).all()


def test_what_would_break_it_is_seen():
    with Recording(), pytest.raises(AssertionError, match="reads a value"):
        torch.zeros(1).item()
    with Recording(), pytest.raises(AssertionError, match="brings in numbers"):
        torch.tensor([1.0])
    with Recording(), pytest.raises(AssertionError, match="a mask selects"):
        torch.zeros(2)[torch.zeros(2, dtype=torch.bool)]


def test_a_fixed_number_of_places_gives_the_same_losses(course, drawn):
    """Places that are not needed change nothing."""
    found = []
    for most in (None, MOST_PARTS):
        course.seeded(drawn[3], 0)
        trainer = Trainer(RECIPE, 3, 17, CPU)
        found.append(trainer.advance(*course.drawn(*drawn, most)))
    torch.testing.assert_close(found[0], found[1], rtol=1e-5, atol=1e-6)
