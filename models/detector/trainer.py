"""A network under training: a step, the schedule, the averaged copy, and what is kept on disk."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import torch
from torch import Tensor, nn

from snapfit.models.detector.device import Workplace
from snapfit.models.detector.losses import losses, named
from snapfit.models.detector.network import PoseNetwork
from snapfit.models.detector.recipe import Recipe
from snapfit.models.detector.targets import Targets
from snapfit.models.errors import TrainingError

_FORMAT = 1
# The averaged copy follows fast at first: it must not remember the first weights.
_AVERAGE_DELAY = 10.0


class Trainer:
    """Trains one network.

    Attributes:
        recipe: how.
        network: as the gradient has it.
        averaged: its moving average, which is what is used in the end.
        step: batches learnt from so far.
        elapsed_s: time spent in training so far, over all runs; kept by who calls `learn`.
        history: losses of every step, by name.
    """

    def __init__(
        self, recipe: Recipe, n_classes: int, n_keypoints: int, workplace: Workplace
    ) -> None:
        self.recipe, self.workplace = recipe, workplace
        torch.manual_seed(recipe.seed)
        network = PoseNetwork(recipe.size, n_classes, n_keypoints)
        self.network = network.to(workplace.device, memory_format=torch.channels_last)
        self.averaged = copy.deepcopy(self.network).eval().requires_grad_(False)
        # On a GPU the numbers that change from step to step lie there, as a CUDA graph wants them.
        is_cuda = workplace.device.type == "cuda"
        rate = recipe.learning_rate
        self.optimiser = torch.optim.AdamW(
            _groups(self.network, recipe.weight_decay),
            lr=torch.tensor(rate, device=workplace.device) if is_cuda else rate,
            betas=(0.9, 0.99),
            fused=is_cuda,
            capturable=is_cuda,
        )
        self._keep = torch.zeros((), device=workplace.device)
        self.step, self.elapsed_s = 0, 0.0
        self._pairs = [
            (list(self.averaged.parameters()), list(self.network.parameters())),
            (list(self.averaged.buffers()), list(self.network.buffers())),
        ]
        self.history: dict[str, list[float]] = {}

    @property
    def progress(self) -> float:
        """Share of the training that is done, 0 to 1."""
        by_step = self.step / self.recipe.steps
        by_time = self.elapsed_s / 60 / self.recipe.minutes if self.recipe.minutes else 0.0
        return min(max(by_step, by_time), 1.0)

    def learn(self, images: Tensor, targets: Targets) -> dict[str, float]:
        """One step; returns the losses before it, by name.

        Args:
            images: (B, 3, H, W) uint8, red first.
            targets: what is true in them.

        Raises:
            TrainingError: the loss is no number.
        """
        self.prepare()
        found = self.advance(images, targets.to(self.workplace.device))
        self.step += 1
        values = named(found.tolist())
        self.remember([values])
        return values

    def prepare(self) -> None:
        """Sets what changes from step to step: the learning rate, and how fast the average goes."""
        rate = self.recipe.learning_rate * rate_at(self.progress, self.recipe)
        for group in self.optimiser.param_groups:
            if isinstance(group["lr"], Tensor):
                group["lr"].fill_(rate)
            else:
                group["lr"] = rate
        step = self.step + 1
        self._keep.fill_(min(self.recipe.average, (1 + step) / (_AVERAGE_DELAY + step)))

    def advance(self, images: Tensor, targets: Targets) -> Tensor:
        """(5,) losses before the step that it makes; asks the device for nothing."""
        self.network.train()
        with self.workplace.precision():
            raw = self.network(as_input(images, self.workplace.device))
        found = losses(raw, targets, self.recipe.weights)
        self.optimiser.zero_grad(set_to_none=True)
        found.total.backward()
        nn.utils.clip_grad_norm_(self.network.parameters(), self.recipe.clip)
        self.optimiser.step()
        self._average()
        return found.stacked.detach()

    def remember(self, steps: Sequence[Mapping[str, float]]) -> None:
        """Puts the losses of the last steps into the history.

        Raises:
            TrainingError: one is no number.
        """
        for ago, values in zip(range(len(steps), 0, -1), steps, strict=True):
            if not math.isfinite(values["total"]):
                where = f"the loss is {values['total']} in step {self.step - ago}"
                raise TrainingError(f"{where}: lower the learning rate")
            for name, value in values.items():
                self.history.setdefault(name, []).append(value)

    def state(self) -> dict[str, Any]:
        """All that is needed to go on."""
        return {
            "format": _FORMAT,
            "recipe": self.recipe.to_json(),
            "classes": self.network.n_classes,
            "keypoints": self.network.n_keypoints,
            "network": self.network.state_dict(),
            "averaged": self.averaged.state_dict(),
            "optimiser": self.optimiser.state_dict(),
            "step": self.step,
            "elapsed_s": self.elapsed_s,
            "history": self.history,
        }

    def resume(self, path: Path) -> None:
        """Goes on where a checkpoint stands.

        Raises:
            TrainingError: it is damaged, or of another recipe, asset or number of keypoints.
        """
        state = read_checkpoint(path)
        mine = self.state()
        for key in ("recipe", "classes", "keypoints"):
            if state[key] != mine[key]:
                problem = f"{path}: was made with another {key}: take another folder, or remove it"
                raise TrainingError(problem)
        self.network.load_state_dict(state["network"])
        self.averaged.load_state_dict(state["averaged"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.step, self.elapsed_s = state["step"], state["elapsed_s"]
        self.history = state["history"]

    def begin_from(self, path: Path) -> int:
        """Takes over from a checkpoint of another training what fits; returns how many tensors.

        The averaged network is what is taken. Layers of other shapes, as those that tell classes
        apart, keep their first weights.

        Raises:
            TrainingError: it is damaged, or nothing of it fits.
        """
        given = read_checkpoint(path)["averaged"]
        mine = self.network.state_dict()
        fitting = {
            name: tensor
            for name, tensor in given.items()
            if name in mine and mine[name].shape == tensor.shape
        }
        if not fitting:
            raise TrainingError(f"{path}: nothing in it fits a network of this size")
        self.network.load_state_dict(fitting, strict=False)
        self.averaged.load_state_dict(fitting, strict=False)
        return len(fitting)

    @torch.no_grad()
    def _average(self) -> None:
        (averaged, weights), statistics = self._pairs
        # All in one call: hundreds of small ones would take a GPU longer than the step itself.
        torch._foreach_mul_(averaged, self._keep)
        torch._foreach_add_(averaged, torch._foreach_mul(weights, 1 - self._keep))
        # Statistics are averages already.
        torch._foreach_copy_(*statistics)


@torch.no_grad()
def settle_statistics(
    network: nn.Module, batches: Iterable[tuple[Tensor, Targets]], workplace: Workplace
) -> None:
    """Takes the statistics of batch normalisation anew, for averaged weights.

    Those that were collected belong to the weights of the last steps (Izmailov et al., "Averaging
    Weights Leads to Wider Optima", UAI 2018, section 3.2).
    """
    norms = [each for each in network.modules() if isinstance(each, nn.BatchNorm2d)]
    momenta = [norm.momentum for norm in norms]
    for norm in norms:
        norm.reset_running_stats()
        # The plain mean of all batches.
        norm.momentum = None
    network.train()
    for images, _ in batches:
        with workplace.precision():
            network(as_input(images, workplace.device))
    network.eval()
    for norm, momentum in zip(norms, momenta, strict=True):
        norm.momentum = momentum


def read_checkpoint(path: Path) -> dict[str, Any]:
    """A checkpoint as it lies on disk.

    Raises:
        TrainingError: it is missing, damaged, or none of ours.
    """
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
    except (OSError, RuntimeError, ValueError, EOFError, KeyError, UnpicklingError) as error:
        raise TrainingError(f"{path}: is no checkpoint ({_first_line(error)})") from error
    if not isinstance(state, dict) or state.get("format") != _FORMAT:
        raise TrainingError(f"{path}: is no checkpoint of this version of snapfit")
    return state


def write_checkpoint(trainer: Trainer, path: Path) -> None:
    """Writes all that is needed to go on; a broken-off writing leaves the one before."""
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_suffix(".partial")
    torch.save(trainer.state(), unfinished)
    unfinished.replace(path)


def as_input(images: Tensor, device: torch.device) -> Tensor:
    """(B, 3, H, W) uint8 to 0 to 1, where they are needed."""
    moved = images.to(device, non_blocking=True, memory_format=torch.channels_last)
    return moved.float() / 255


def rate_at(progress: float, recipe: Recipe) -> float:
    """Share of the highest learning rate: it rises in a line, then falls as a cosine does."""
    if progress < recipe.warm_up:
        return max(progress / recipe.warm_up, 1e-3)
    fallen = (progress - recipe.warm_up) / (1 - recipe.warm_up)
    return recipe.final_rate + (1 - recipe.final_rate) * (1 + math.cos(math.pi * fallen)) / 2


def _groups(network: nn.Module, weight_decay: float) -> list[dict[str, Any]]:
    parameters = list(network.parameters())
    return [
        {"params": [p for p in parameters if p.ndim > 1], "weight_decay": weight_decay},
        {"params": [p for p in parameters if p.ndim <= 1], "weight_decay": 0.0},
    ]


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
