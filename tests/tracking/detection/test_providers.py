"""What runs a network, by short names."""

import onnxruntime
import pytest

from snapfit.tracking.detection.providers import PROVIDERS, providers_here, short_name
from snapfit.tracking.errors import TrackingError


@pytest.fixture
def _has_cuda(monkeypatch: pytest.MonkeyPatch) -> None:
    there = [PROVIDERS["cuda"], PROVIDERS["cpu"]]
    monkeypatch.setattr(onnxruntime, "get_available_providers", lambda: there)


@pytest.mark.usefixtures("_has_cuda")
def test_the_order_is_kept_and_the_cpu_comes_last(caplog) -> None:
    assert providers_here(["cuda"]) == ("CUDAExecutionProvider", "CPUExecutionProvider")
    assert providers_here(["cpu", "cuda"]) == ("CPUExecutionProvider", "CUDAExecutionProvider")
    assert caplog.text == ""


@pytest.mark.usefixtures("_has_cuda")
def test_what_is_not_there_is_passed_over_and_told(caplog) -> None:
    assert providers_here(["directml"]) == ("CPUExecutionProvider",)
    assert "has no provider 'directml'; it has CUDAExecutionProvider" in caplog.text


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(TrackingError, match=r"no provider 'abacus'.*cpu, cuda, tensorrt, coreml"):
        providers_here(["cpu", "abacus"])


def test_names_go_both_ways() -> None:
    assert {short_name(theirs) for theirs in PROVIDERS.values()} == set(PROVIDERS)
    assert short_name("AzureExecutionProvider") == "AzureExecutionProvider"
