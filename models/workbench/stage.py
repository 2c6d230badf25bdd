"""Pictures of the bench one sample a pixel: what stands once a while, what moves in its window."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Part
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.rasteriser import intrinsics_of, render
from snapfit.models.workbench import cover_kernels, kernels, stage_kernels
from snapfit.models.workbench.cover_kernels import MOVING, SHADOWED
from snapfit.models.workbench.hand import Body
from snapfit.models.workbench.light import DIM_AMBIENT, Light, moving_lamp
from snapfit.models.workbench.scene import Lamp, Scene, ground_seen, linear
from snapfit.models.workbench.shading import (
    PART_GLOSS,
    Studio,
    Surfaces,
    Window,
    encoding,
    item_bodies,
)

Singles = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]

# Labels: 0 is the bench, then the parts from 1, things on the bench and the hand.
ITEM_LABEL, HAND_LABEL = 100, 200
_MARGIN_PX = 6
_SMOOTH_PX = 9


@dataclass(frozen=True, eq=False)
class Backdrop:
    """All that stands for a while, as it is seen without what moves.

    Attributes:
        surfaces: one sample a pixel.
        label: (H, W).
        bodies: mesh and `world_from_body` of what throws shadows.
        light: (H, W, 3) linear, under the room's lamps.
        sample: (H, W, 3) the same by one sample a pixel, not smoothed.
        shadows: of the room's lamps.
    """

    surfaces: Surfaces
    label: Bytes
    bodies: list[tuple[Mesh, Pose]]
    light: Singles
    sample: Singles
    shadows: tuple[Singles, Bytes]


@dataclass(frozen=True, eq=False)
class Picture:
    """A clean picture.

    Attributes:
        color: (H, W, 3) uint8, blue first, without noise.
        depth: (H, W) true depth, m.
        label: (H, W) what is seen.
    """

    color: Bytes
    depth: Singles
    label: Bytes


class Stage:
    """Draws parts and hands on a bench."""

    def __init__(self, scene: Scene, parts: Sequence[Part]) -> None:
        self.scene, self.parts = scene, tuple(parts)
        self._table = encoding()
        self._fixed = Light(scene, scene.lamps, scene.ambient)
        self._whole = Window(0, 0, scene.camera.width, scene.camera.height)
        self._surfaces, self._label = self._empty()
        items = [(item.mesh, item.world_from_body) for item in scene.items]
        self._fixed.stand(items)
        self._items = items
        self._sample = self._shade(self._whole, self._surfaces, self._fixed)
        self._light = linear(Studio(scene, parts).empty)

    def backdrop(self, world_from_part: Mapping[str, Pose]) -> Backdrop:
        """What stands, with the parts that do."""
        names = [part.name for part in self.parts]
        bodies = self._part_bodies(world_from_part)
        surfaces = self._surfaces.at(slice(None), slice(None))
        label = self._label.copy()
        labels = [names.index(name) + 1 for name in world_from_part]
        self._cover(surfaces, label, self._whole, bodies, labels)
        standing = self._items + [(body.mesh, body.world_from_body) for body in bodies]
        self._fixed.stand(standing)
        sample = self._shade(self._whole, surfaces, self._fixed)
        light = np.zeros_like(sample)
        mask = (label > 0) & (label < ITEM_LABEL)
        mark = np.where(mask, MOVING, SHADOWED).astype(np.uint8)
        stage_kernels.lay_over(self._light, self._sample, sample, mark, 1.0, light)
        smooth = np.empty_like(light)
        stage_kernels.soften_edges(light, np.where(mask, label, 0).astype(np.uint8), smooth)
        return Backdrop(surfaces, label, standing, smooth, sample, self._fixed.keep())

    def picture(
        self,
        backdrop: Backdrop,
        instants: Sequence[tuple[Mapping[str, Pose], Sequence[Body]]],
        moving_light: tuple[float, float] | None = None,
    ) -> Picture:
        """One exposure.

        Args:
            backdrop: of what stands.
            instants: `world_from_part` of what moves and the bodies of the hand, at moments that
                are spread evenly over the exposure; depth is that of the middle one.
            moving_light: time (s) and phase of the light that goes around; None is the room's.
        """
        if moving_light is None:
            light = self._fixed
            light.put_back(backdrop.shadows)
            lamps: Sequence[Lamp] = self.scene.lamps
            standing, sample = backdrop.light, backdrop.sample
        else:
            lamps = [moving_lamp(*moving_light)]
            light = Light(self.scene, lamps, DIM_AMBIENT)
            light.stand(backdrop.bodies)
            sample = self._shade(self._whole, backdrop.surfaces, light)
            standing = np.empty_like(sample)
            stage_kernels.soften_edges(sample, backdrop.label, standing)
        bodies = [[*self._part_bodies(poses), *hand] for poses, hand in instants]
        window = self._window([body for each in bodies for body in each], lamps)
        if window is None:
            color = stage_kernels.encoded(standing, self._table)
            return Picture(color, backdrop.surfaces.depth, backdrop.label)
        total = np.zeros((*backdrop.label[window.slices].shape, 3), dtype=np.float32)
        depth, label = backdrop.surfaces.depth.copy(), backdrop.label.copy()
        for i, ((poses, _), drawn) in enumerate(zip(instants, bodies, strict=True)):
            surfaces = backdrop.surfaces.at(*window.slices)
            seen = backdrop.label[window.slices].copy()
            mark = self._cover(surfaces, seen, window, drawn, self._labels(poses, drawn))
            light.move([(body.mesh, body.world_from_body) for body in drawn])
            lit = cover_kernels.mark_shadowed(
                surfaces.depth,
                surfaces.normal,
                intrinsics_of(window.camera(self.scene.camera)),
                light.lamps,
                len(lamps),
                mark,
            )
            after = self._shade(window, replace(surfaces, depth=lit), light)
            stage_kernels.lay_over(
                np.ascontiguousarray(standing[window.slices]),
                np.ascontiguousarray(sample[window.slices]),
                after,
                mark,
                1 / len(instants),
                total,
            )
            if i == len(instants) // 2:
                depth[window.slices], label[window.slices] = surfaces.depth, seen
                edges = np.where(mark == MOVING, seen, 0).astype(np.uint8)
        soft = np.empty_like(total)
        stage_kernels.soften_edges(total, edges, soft)
        picture = standing.copy()
        picture[window.slices] = soft
        return Picture(stage_kernels.encoded(picture, self._table), depth, label)

    def _labels(self, poses: Mapping[str, Pose], drawn: Sequence[Body]) -> list[int]:
        names = [part.name for part in self.parts]
        own = [names.index(name) + 1 for name in poses]
        return own + [HAND_LABEL] * (len(drawn) - len(own))

    def _part_bodies(self, world_from_part: Mapping[str, Pose]) -> list[Body]:
        parts = {part.name: part for part in self.parts}
        return [
            Body(parts[name].mesh, pose, parts[name].color_rgb, PART_GLOSS)
            for name, pose in world_from_part.items()
        ]

    def _cover(
        self,
        surfaces: Surfaces,
        label: Bytes,
        window: Window,
        bodies: Sequence[Body],
        labels: Sequence[int],
    ) -> Bytes:
        """Draws bodies in front, in place; returns `cover_kernels`' marks (H, W)."""
        mark = np.zeros(label.shape, dtype=np.uint8)
        if not bodies:
            return mark
        camera = window.camera(self.scene.camera)
        view = self.scene.camera_from_world
        seen = render(camera, [(b.mesh, view @ b.world_from_body) for b in bodies], normals=True)
        if HAND_LABEL in labels and seen.normal is not None:
            smooth_normals(seen.normal, seen.part_id, labels.index(HAND_LABEL) + 1)
        cover_kernels.put_before(
            surfaces.depth,
            surfaces.normal,
            surfaces.albedo,
            surfaces.gloss,
            label,
            seen.depth,
            seen.normal,
            seen.part_id,
            linear(np.array([b.color_rgb[::-1] for b in bodies], dtype=np.uint8)),
            np.array([body.gloss for body in bodies], dtype=np.float32),
            np.array(labels, dtype=np.uint8),
            mark,
        )
        return mark

    def _window(self, bodies: Sequence[Body], lamps: Sequence[Lamp]) -> Window | None:
        """Where bodies and their shadows on the bench may be seen; None if nowhere."""
        if not bodies:
            return None
        points = np.vstack([_corners(body) for body in bodies])
        touched = [points]
        for lamp in lamps:
            for dx, dy in ((0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5)):
                light = np.array(lamp.position_m) + lamp.diameter_m * np.array([dx, dy, 0])
                height = np.clip(points[:, 2:], 0, 0.8 * light[2])
                touched.append(light + light[2] / (light[2] - height) * (points - light))
        camera = self.scene.camera
        inside = self.scene.camera_from_world.transform(np.concatenate(touched))
        inside[:, 2] = np.maximum(inside[:, 2], 0.05)
        pixels = camera.project(inside)
        size = (camera.width, camera.height)
        left, top = np.clip(np.floor(pixels.min(axis=0)) - _MARGIN_PX, 0, size).astype(int) & ~1
        right, bottom = np.clip(np.ceil(pixels.max(axis=0)) + _MARGIN_PX, 0, size).astype(int)
        if left >= right or top >= bottom:
            return None
        return Window(int(left), int(top), int(right), int(bottom))

    def _shade(self, window: Window, surfaces: Surfaces, light: Light) -> Singles:
        samples: Singles = kernels.shade(
            surfaces.depth,
            surfaces.normal,
            surfaces.albedo,
            surfaces.gloss,
            intrinsics_of(window.camera(self.scene.camera)),
            np.array([window.left, window.top]),
            light.lamps,
        )
        return samples

    def _empty(self) -> tuple[Surfaces, Bytes]:
        """Bench and things, one sample a pixel."""
        scene = self.scene
        depth, albedo = ground_seen(scene, scene.camera)
        normal = np.empty((*depth.shape, 3), dtype=np.float32)
        normal[...] = scene.up
        surfaces = Surfaces(depth, normal, albedo, np.zeros_like(depth))
        seen = render(scene.camera, item_bodies(scene), normals=True)
        label = np.zeros(depth.shape, dtype=np.uint8)
        wins = (seen.depth > 0) & (seen.depth < depth)
        label[wins] = ITEM_LABEL - 1 + seen.part_id[wins]
        colors = np.array([item.color_rgb[::-1] for item in scene.items], dtype=np.uint8)
        gloss = np.array([item.gloss for item in scene.items], dtype=np.float32)
        surfaces.cover(seen, linear(colors), gloss)
        return surfaces, label


def _corners(body: Body) -> Array:
    """(8, 3) corners of a body's box, world frame, m."""
    low, high = body.mesh.vertices.min(axis=0), body.mesh.vertices.max(axis=0)
    unit = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    return body.world_from_body.transform(low + unit * (high - low))


def smooth_normals(normal: Singles, ids: Bytes, first: int) -> None:
    """Rounds off what is drawn from the `first` id on, in place: skin has no edges."""
    size = (_SMOOTH_PX, _SMOOTH_PX)
    mean = cv2.blur(cv2.blur(cover_kernels.only_where(normal, ids, first), size), size)
    cover_kernels.unit_where(mean, ids, first, normal)
