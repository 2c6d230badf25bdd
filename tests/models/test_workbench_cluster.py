"""Rendering on a cluster: the same pictures by each backend that is installed, clear errors."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from snapfit.models.errors import DatasetError
from snapfit.models.workbench.dataset import Order, render_dataset
from snapfit.models.workbench.fan_out import fan_out
from snapfit.models.workbench.split import Condition

CLAMP = "hobby-corner-clamp"


def installed(module, extra):
    reason = f"{module} is not installed: pip install 'snapfit[{extra}]'"
    return pytest.mark.skipif(find_spec(module) is None, reason=reason)


def rendered(folder, backend):
    order = Order(folder, (CLAMP,), (Condition.NORMAL,), limit=80, scale=0.1)
    summary = render_dataset(order, jobs=2, backend=backend)
    assert summary["frames"] == 80
    pictures = sorted((folder / CLAMP / "test" / "normal").rglob("*.[jp][pn]g"))
    return {path.relative_to(folder): path.read_bytes() for path in pictures}


@pytest.mark.slow
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize(
    "backend",
    [
        pytest.param("ray", marks=installed("ray", "ray")),
        pytest.param("dask", marks=installed("distributed", "dask")),
    ],
)
def test_a_cluster_renders_the_same_pictures(tmp_path, backend):
    here = rendered(tmp_path / "here", "loky")
    assert len(here) >= 2 * 80
    assert rendered(tmp_path / "cluster", backend) == here


@pytest.mark.slow
@installed("distributed", "dask")
@pytest.mark.filterwarnings("default")
def test_a_scheduler_that_does_not_answer_is_told(monkeypatch):
    import dask

    with (
        dask.config.set(
            {"scheduler-address": "tcp://127.0.0.1:9", "distributed.comm.timeouts.connect": "1s"}
        ),
        pytest.raises(DatasetError, match="no connection to the cluster at tcp://127"),
    ):
        list(fan_out(len, [[1], [2]], 2, "dask"))


def test_a_module_that_fails_for_another_reason_is_not_taken_for_the_backend():
    def render_run(run):
        raise ModuleNotFoundError("No module named 'teapot'", name="teapot")

    with pytest.raises(ModuleNotFoundError, match="teapot"):
        list(fan_out(render_run, [Path()], 1, "loky"))
