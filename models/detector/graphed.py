"""Training as a CUDA graph: a step is recorded once and then replayed.

A step of a small network is thousands of small kernels. Launched one by one, they take a processor
longer than the GPU needs to run them; replayed as a graph they take it a single call, so that its
cores are free to render. What a graph cannot do is to ask the GPU for a value or to copy from the
main memory: all that changes from step to step lies in tensors that are written before a replay.
"""

from __future__ import annotations

import torch
from torch import Tensor

from snapfit.models.detector.batches import Course
from snapfit.models.detector.losses import named
from snapfit.models.detector.trainer import Trainer

MOST_PARTS = 40
"""Places for parts in a view. In 80 views of six tiles each, the Nano Chuck and LiftPod showed 23
on average and 44 at most, of which at most 38 were to be found: those have the first places."""

_EAGER_STEPS = 4
# Losses are read in one go: each reading waits for the GPU.
_READ_EVERY = 50


class GraphedSteps:
    """The steps of a training, replayed; the first few of each run go one kernel at a time.

    The same training as with `Trainer.learn`, but for the order in which sums are taken.
    """

    def __init__(self, trainer: Trainer, course: Course, memory: Tensor) -> None:
        """Prepares; nothing is learnt yet.

        Args:
            trainer: on a GPU.
            course: of the training.
            memory: its images, which the GPU holds.
        """
        self._trainer, self._course, self._memory = trainer, course, memory
        self._size, device = trainer.recipe.batch, trainer.workplace.device
        self._stream = torch.cuda.Stream(device)
        self._generator = torch.Generator(device)
        count = len(course.places(0, self._size))
        self._images = torch.zeros(count, dtype=torch.int64, device=device)
        self._losses = torch.zeros((_READ_EVERY, 5), device=device)
        self._graph: torch.cuda.CUDAGraph | None = None
        self._found = self._losses[0]
        self._begun, self._unread = trainer.step, 0

    def learn(self) -> None:
        """Makes a step, or rather has it made: the GPU is still at work when this returns.

        Raises:
            TrainingError: a loss of the last steps is no number.
        """
        trainer = self._trainer
        with torch.cuda.stream(self._stream):
            places = torch.tensor(self._course.places(trainer.step, self._size)).pin_memory()
            self._images.copy_(places, non_blocking=True)
            self._course.seeded(self._generator, trainer.step)
            trainer.prepare()
            if trainer.step - self._begun < _EAGER_STEPS:
                self._found = self._step()
            else:
                self._replay()
            self._losses[self._unread].copy_(self._found)
        trainer.step += 1
        self._unread += 1
        if self._unread == _READ_EVERY:
            self.read()

    def read(self) -> None:
        """Waits for the GPU, and puts the losses of the steps so far into the history.

        Raises:
            TrainingError: one is no number.
        """
        with torch.cuda.stream(self._stream):
            rows = self._losses[: self._unread].tolist()
        self._unread = 0
        self._trainer.remember([named(row) for row in rows])

    def _step(self) -> Tensor:
        images, targets = self._course.drawn(
            self._memory, self._images, self._images, self._generator, MOST_PARTS
        )
        return self._trainer.advance(images, targets)

    def _replay(self) -> None:
        if self._graph is None:
            self._graph = torch.cuda.CUDAGraph()
            self._graph.register_generator_state(self._generator)
            # Other threads may go on using the GPU meanwhile.
            mode = "thread_local"
            with torch.cuda.graph(self._graph, stream=self._stream, capture_error_mode=mode):
                self._found = self._step()
        self._graph.replay()
