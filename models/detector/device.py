"""Where a network is trained, and in which precision."""

from __future__ import annotations

import os
import platform
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

import torch

from snapfit.models.errors import TrainingError


@dataclass(frozen=True, eq=False)
class Workplace:
    """A processor for training.

    Attributes:
        device: of PyTorch.
        name: in words.
        is_mixed: whether products are computed in bfloat16, which needs no scaling of the loss.
        workers: threads that read images beside it.
    """

    device: torch.device
    name: str
    is_mixed: bool
    workers: int

    def precision(self) -> AbstractContextManager[None]:
        """The context in which the network runs forward."""
        context: AbstractContextManager[None] = torch.autocast(
            self.device.type, dtype=torch.bfloat16, enabled=self.is_mixed
        )
        return context


CPU = Workplace(torch.device("cpu"), "CPU", is_mixed=False, workers=1)
"""The plain CPU, whatever else there is."""


def workplace(wanted: str = "auto", *, workers: int | None = None) -> Workplace:
    """The GPU where there is one, otherwise the CPU.

    Args:
        wanted: auto, cpu, cuda, or a device's name in PyTorch, as cuda:1.
        workers: threads that read images; by the number of cores if absent.

    Raises:
        TrainingError: there is no such device.
    """
    name = ("cuda" if torch.cuda.is_available() else "cpu") if wanted == "auto" else wanted
    try:
        device = torch.device(name)
        torch.empty(1, device=device)
    except (RuntimeError, AssertionError, NotImplementedError) as error:
        first = str(error).splitlines()[0]
        raise TrainingError(f"there is no device {name!r} to train on: {first}") from error
    cores = os.cpu_count() or 1
    if device.type == "cuda":
        words = torch.cuda.get_device_name(device)
        return Workplace(device, words, True, max(1, cores - 1) if workers is None else workers)
    processor = _cpu_info("model name") or platform.machine()
    words = f"{processor}, {torch.get_num_threads()} threads"
    return Workplace(device, words, _has_bfloat16(device), 1 if workers is None else workers)


def _has_bfloat16(device: torch.device) -> bool:
    """Whether bfloat16 is faster: other processors would only emulate it."""
    flags = _cpu_info("flags")
    return device.type == "cpu" and ("avx512_bf16" in flags or "amx_bf16" in flags)


def _cpu_info(key: str) -> str:
    """A line of Linux' description of the processor; empty elsewhere."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
    return next((line.partition(":")[2].strip() for line in lines if line.startswith(key)), "")
