"""Batches of training views, the same from the same seed wherever a run goes on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields

import numpy as np
import torch
from torch import Tensor

from snapfit.models.detector.cutting import cut_out, relit
from snapfit.models.detector.device import Workplace
from snapfit.models.detector.label_table import Group, LabelTable, label_table
from snapfit.models.detector.pictures import (
    HeldPictures,
    Pictures,
    ReadPictures,
    pictures_for,
)
from snapfit.models.detector.shape_table import ShapeTable, shape_table
from snapfit.models.detector.targets import Targets, at
from snapfit.models.detector.view_batch import ViewBatch, labelled, sampled_views
from snapfit.models.detector.views import ViewParameters, centered

Batch = tuple[Tensor, Targets]

_IMAGES_A_VIEW = 2
"""Tiles show parts of so many images."""


class Course:
    """An endless row of batches: each round shows every image once, in another order.

    Most views of a batch are tiles, each laid around another part; the others show more of one
    image. Batch n depends on the seed, n and the batch's size alone.
    """

    def __init__(
        self, groups: Sequence[Group], parameters: ViewParameters, seed: int, place: Workplace
    ) -> None:
        """Puts the labels, and on a GPU the images, where they are needed.

        Args:
            groups: images to learn from, with the shapes of their parts.
            parameters: of the views.
            seed: of order and views.
            place: where the network is trained.

        Raises:
            DatasetError: there is no image, one is missing, or they are of several sizes.
        """
        self._table = label_table(groups).to(place.device)
        self._shapes = _shapes_of(groups).to(place.device)
        self._parameters, self._seed, self._device = parameters, seed, place.device
        samples = [sample for some, _ in groups for sample in some]
        self._pictures: Pictures = pictures_for(samples, place)

    @property
    def memory(self) -> Tensor | None:
        """All images, as `cutting.cut_out` wants them, where the device holds them."""
        return self._pictures.memory if isinstance(self._pictures, HeldPictures) else None

    def batches(self, size: int, numbers: range) -> Iterator[Batch]:
        """Images (B, 3, H, W) uint8, red first, and what is true in them, on the device."""
        generator = torch.Generator(self._device)
        for number in numbers:
            places = self.places(number, size)
            memory, rows = self._pictures.take(places)
            images = torch.tensor(places, device=self._device)
            yield self.drawn(memory, rows, images, self.seeded(generator, number))
            if number + 1 < numbers.stop:
                self._pictures.expect(self.places(number + 1, size))

    def places(self, number: int, size: int) -> list[int]:
        """The images of a batch: so many a view, some of which only the tiles use."""
        first = number * size * _IMAGES_A_VIEW
        wanted = range(first, first + size * _IMAGES_A_VIEW)
        rounds = {each // len(self._table) for each in wanted}
        orders = {
            each: np.random.default_rng((self._seed, each)).permutation(len(self._table))
            for each in rounds
        }
        return [int(orders[w // len(self._table)][w % len(self._table)]) for w in wanted]

    def seeded(self, generator: torch.Generator, number: int) -> torch.Generator:
        """The generator as batch `number` needs it."""
        return generator.manual_seed(self._seed * 1_000_003 + number)

    def drawn(
        self,
        memory: Tensor,
        rows: Tensor,
        images: Tensor,
        generator: torch.Generator,
        most: int | None = None,
    ) -> Batch:
        """A batch of views of these images.

        Args:
            memory, rows: the images, and where each of the batch's is, as `Pictures.take` has them.
            images: (n,) their places in the course.
            generator: where chance comes from, on the device.
            most: places for parts in a view. Given, nothing depends on what is drawn but values,
                as a CUDA graph wants it; what has no place is left out, the hardly seen first.
        """
        p = self._parameters
        size = len(images) // _IMAGES_A_VIEW
        n_tiled = round(size * p.tiled_share) if p.tiles[0] * p.tiles[1] > 1 else 0
        split = n_tiled * _IMAGES_A_VIEW
        found = []
        if split:
            found.append(self._seen(memory, rows[:split], images[:split], p.tiles, generator))
        if n_tiled < size:
            # Of the two images, the first.
            rest = slice(split, None, _IMAGES_A_VIEW)
            found.append(self._seen(memory, rows[rest], images[rest], (1, 1), generator))
        pictures = torch.cat([each for each, _ in found])
        return pictures, joined([targets for _, targets in found], most)

    def _seen(
        self,
        memory: Tensor,
        rows: Tensor,
        images: Tensor,
        tiles: tuple[int, int],
        generator: torch.Generator,
    ) -> Batch:
        """Views of so many tiles, each view of as many images as there are parts to show."""
        p, n_tiles, device = self._parameters, tiles[0] * tiles[1], self._device
        views_of = 1 if n_tiles == 1 else _IMAGES_A_VIEW
        count = len(images) // views_of
        slots = torch.arange(n_tiles, device=device) * views_of // n_tiles
        which = torch.arange(count, device=device)[:, None] * views_of + slots
        which = which.flatten()
        turns = torch.arange(n_tiles, device=device) - torch.searchsorted(slots, slots)
        aims = aimed_boxes(self._table, images, which, turns.repeat(count), generator)
        size = p.width_px // tiles[1], p.height_px // tiles[0]
        share = 1.0 if n_tiles > 1 else p.aimed_share
        views = sampled_views(self._table, images[which], aims, size, p, share, generator)
        pictures = cut_out(memory, rows[which], self._table.size, views)
        lit = relit(pictures, p, generator).round().to(torch.uint8)
        return beside(lit, labelled(views, self._table, self._shapes), tiles)


def aimed_boxes(
    table: LabelTable, images: Tensor, which: Tensor, turns: Tensor, generator: torch.Generator
) -> Tensor:
    """(T, 4) boxes of seen parts to lay views around: another one each as far as there are any.

    Args:
        table: of the images.
        images: (n,) of the batch.
        which: (T,) place in `images` of each view's image.
        turns: (T,) the how manieth view of that image each is.
        generator: of the order of the parts.

    Returns:
        (0, 0, 0, 0) where no part is seen.
    """
    is_seen = table.is_seen[images] & (table.classes[images] >= 0)
    chance = torch.rand(is_seen.shape, generator=generator, device=generator.device)
    keys = chance + ~is_seen
    order = keys.argsort(dim=1)
    count = is_seen.sum(dim=1)
    part = order[which, turns % count[which].clamp(min=1)]
    boxes = table.boxes[images[which], part]
    return boxes * (count[which] > 0)[:, None]


def beside(pictures: Tensor, targets: Targets, tiles: tuple[int, int]) -> Batch:
    """Tiles (V * rows * columns, 3, h, w), row by row, as V views; their parts likewise."""
    rows, columns = tiles
    height, width = pictures.shape[2:]
    grid = pictures.unflatten(0, (-1, rows, columns)).permute(0, 3, 1, 4, 2, 5)
    whole = grid.reshape(-1, 3, rows * height, columns * width)
    number = torch.arange(rows * columns, device=pictures.device)
    shift = torch.stack([number % columns * width, number // columns * height], dim=-1)
    count = len(whole)
    shift = shift.repeat(count, 1)[:, None].to(torch.float32)
    boxes = targets.boxes + torch.cat([shift, shift], dim=-1)
    points = targets.keypoints.clone()
    points[..., :2] += shift[:, :, None]
    pieces = targets.classes, boxes, points, targets.is_ignored
    together = [each.unflatten(0, (count, -1)).flatten(1, 2) for each in pieces]
    return whole, Targets(*together)


def joined(some: Sequence[Targets], most: int | None = None) -> Targets:
    """The targets of several sets of views, with no more places than there are parts, or `most`.

    Of more parts than `most`, those that are hardly seen are left out first.
    """
    ranks = [2 * (each.classes < 0).to(torch.int8) for each in some]
    if most is None:
        most = max(1, *(int((each.classes >= 0).sum(dim=1).max()) for each in some))
    else:
        ranks = [rank + each.is_ignored for rank, each in zip(ranks, some, strict=True)]
    pieces = [_compact(each, rank, most) for each, rank in zip(some, ranks, strict=True)]
    return Targets(
        *(torch.cat([getattr(each, field.name) for each in pieces]) for field in fields(Targets))
    )


def _compact(targets: Targets, rank: Tensor, most: int) -> Targets:
    """The `most` of lowest rank of each view; if there are fewer, it is filled up."""
    order = rank.argsort(dim=1, stable=True)[:, :most]
    missing = most - order.shape[1]
    found = []
    for field in fields(Targets):
        values = at(getattr(targets, field.name), order)
        if missing > 0:
            shape = len(values), missing, *values.shape[2:]
            filler = values.new_full(shape, -1 if field.name == "classes" else 0)
            values = torch.cat([values, filler], dim=1)
        found.append(values)
    return Targets(*found)


def whole_batches(
    groups: Sequence[Group], parameters: ViewParameters, batch: int, place: Workplace
) -> Iterator[Batch]:
    """Images as they are, in order.

    Raises:
        DatasetError: there is none, one is missing, or they are of several sizes.
    """
    table = label_table(groups)
    there, shapes = table.to(place.device), _shapes_of(groups).to(place.device)
    pictures = ReadPictures([sample for some, _ in groups for sample in some], place)
    matrix = torch.from_numpy(centered(table.size, parameters)).to(place.device, torch.float32)
    size = parameters.width_px, parameters.height_px
    for start in range(0, len(table), batch):
        places = range(start, min(start + batch, len(table)))
        count = len(places)
        views = ViewBatch(
            torch.tensor(places, device=place.device),
            matrix.repeat(count, 1, 1),
            torch.zeros(count, device=place.device),
            *size,
        )
        images = cut_out(*pictures.take(places), table.size, views).round().to(torch.uint8)
        yield images, joined([labelled(views, there, shapes)])


def _shapes_of(groups: Sequence[Group]) -> ShapeTable:
    return shape_table([shape for _, known in groups for shape in known.values()])
