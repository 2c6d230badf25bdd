"""From poses to a clean picture: what is static is shaded once, what moves in its own window."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Part
from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.rasteriser import Rendering, intrinsics_of, render
from snapfit.models.workbench import kernels
from snapfit.models.workbench.scene import Lamp, Scene, ground_seen, linear, looking_at

Singles = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]

PART_GLOSS = 0.16
_MAP_PX = 768
# Half the width that a lamp's shadow map covers on the bench: all of it, and the working place.
_WIDE_M, _NARROW_M = 0.85, 0.42
_MARGIN_PX = 6


@dataclass(frozen=True)
class Window:
    """A rectangle of the picture, px: from inclusive, to exclusive."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def slices(self) -> tuple[slice, slice]:
        """Rows and columns."""
        return slice(self.top, self.bottom), slice(self.left, self.right)

    def camera(self, camera: PinholeCamera, factor: int = 1, border: int = 0) -> PinholeCamera:
        """A camera that sees just this, at `factor` times the size, and `border` pixels around."""
        whole = camera.scaled(factor)
        return PinholeCamera(
            width=(self.right - self.left) * factor + 2 * border,
            height=(self.bottom - self.top) * factor + 2 * border,
            fx=whole.fx,
            fy=whole.fy,
            cx=whole.cx - self.left * factor + border,
            cy=whole.cy - self.top * factor + border,
        )


@dataclass(frozen=True, eq=False)
class Surfaces:
    """What is seen at each sample: depth (m), unit normal (camera frame), albedo, gloss."""

    depth: Singles
    normal: Singles
    albedo: Singles
    gloss: Singles

    def at(self, rows: slice, columns: slice) -> Surfaces:
        """A window's own copy."""
        return Surfaces(
            self.depth[rows, columns].copy(),
            self.normal[rows, columns].copy(),
            self.albedo[rows, columns].copy(),
            self.gloss[rows, columns].copy(),
        )

    def cover(self, seen: Rendering, albedo: Singles, gloss: Singles) -> None:
        """Puts bodies in front, in place; albedo (bodies, 3) and gloss (bodies,) by body."""
        wins = (seen.depth > 0) & (seen.depth < self.depth)
        body = seen.part_id[wins].astype(np.intp) - 1
        self.depth[wins] = seen.depth[wins]
        if seen.normal is not None:
            self.normal[wins] = seen.normal[wins]
        self.albedo[wins] = albedo[body]
        self.gloss[wins] = gloss[body]


class Studio:
    """Shades a scene with parts in it.

    Light is sampled at twice the size of the picture; samples carry a border of 2 for the filter.
    """

    def __init__(self, scene: Scene, parts: Sequence[Part]) -> None:
        self.scene = scene
        self.parts = tuple(parts)
        self.whole = Window(0, 0, scene.camera.width, scene.camera.height)
        self._encoding = encoding()
        self._albedo = linear(np.array([p.color_rgb[::-1] for p in parts], dtype=np.uint8))
        self._gloss = np.full(len(parts), PART_GLOSS, dtype=np.float32)
        self._ground = self._static_surfaces()
        wide = [LampCamera(lamp, scene, _WIDE_M) for lamp in scene.lamps]
        self._narrow = [LampCamera(lamp, scene, _NARROW_M) for lamp in scene.lamps]
        items = [(item.mesh, item.world_from_body) for item in scene.items]
        self._item_shadows = [view.shadow(items) for view in wide]
        self._lamps = kernel_lamps(
            scene, scene.lamps, scene.ambient, [*wide, *self._narrow], *self._shadows({})
        )
        self.empty = self._shade(self.whole, self._ground, self._shadows({}))
        self.empty_depth = _static_depth(scene, scene.camera)

    def layer(self, world_from_part: Mapping[str, Pose]) -> Bytes:
        """The whole picture (H, W, 3), blue first, with some parts, which then count as static."""
        picture = self.empty.copy()
        self.paint(picture, world_from_part, world_from_part)
        return picture

    def paint(
        self, picture: Bytes, world_from_part: Mapping[str, Pose], changed: Iterable[str]
    ) -> None:
        """Shades anew, in place, where the named parts and their shadows are.

        Args:
            picture: (H, W, 3) uint8 with all the other parts in it.
            world_from_part: every part that is there.
            changed: those that are new in the picture, or stand elsewhere.
        """
        windows = [self.window(name, world_from_part[name]) for name in changed]
        if not windows:
            return
        window = Window(
            min(each.left for each in windows),
            min(each.top for each in windows),
            max(each.right for each in windows),
            max(each.bottom for each in windows),
        )
        rows = slice(2 * window.top, 2 * window.bottom + 4)
        surfaces = self._ground.at(rows, slice(2 * window.left, 2 * window.right + 4))
        camera = window.camera(self.scene.camera, 2, border=2)
        there = [i for i, part in enumerate(self.parts) if part.name in world_from_part]
        seen = render(camera, self._bodies(world_from_part), normals=True)
        surfaces.cover(seen, self._albedo[there], self._gloss[there])
        picture[window.slices] = self._shade(window, surfaces, self._shadows(world_from_part))

    def window(self, name: str, world_from_part: Pose) -> Window:
        """Where a part and its shadows on the bench fall in the picture."""
        mesh = next(part.mesh for part in self.parts if part.name == name)
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        points = world_from_part.transform(low + corners * (high - low))
        touched = [points]
        for lamp in self.scene.lamps:
            for dx, dy in ((0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5)):
                light = np.array(lamp.position_m) + lamp.diameter_m * np.array([dx, dy, 0])
                reach = light[2] / (light[2] - points[:, 2:])
                touched.append(light + reach * (points - light))
        camera = self.scene.camera
        pixels = camera.project(self.scene.camera_from_world.transform(np.concatenate(touched)))
        left, top = np.floor(pixels.min(axis=0)).astype(int) - _MARGIN_PX
        right, bottom = np.ceil(pixels.max(axis=0)).astype(int) + _MARGIN_PX
        return Window(
            max(left, 0), max(top, 0), min(right, camera.width), min(bottom, camera.height)
        )

    def _bodies(self, world_from_part: Mapping[str, Pose]) -> list[tuple[Mesh, Pose]]:
        there = [part for part in self.parts if part.name in world_from_part]
        return [
            (part.mesh, self.scene.camera_from_world @ world_from_part[part.name]) for part in there
        ]

    def _shadows(self, world_from_part: Mapping[str, Pose]) -> tuple[Singles, Bytes]:
        """Shadow maps (M, H, W), m, and where something is in reach of them."""
        there = [part for part in self.parts if part.name in world_from_part]
        bodies = [(part.mesh, world_from_part[part.name]) for part in there]
        maps = [*self._item_shadows, *(view.shadow(bodies) for view in self._narrow)]
        return np.stack([depth for depth, _ in maps]), np.stack([cast for _, cast in maps])

    def _shade(self, window: Window, surfaces: Surfaces, shadows: tuple[Singles, Bytes]) -> Bytes:
        samples = kernels.shade(
            surfaces.depth,
            surfaces.normal,
            surfaces.albedo,
            surfaces.gloss,
            intrinsics_of(window.camera(self.scene.camera, 2, border=2)),
            np.array([2 * window.left, 2 * window.top]),
            self._lamps._replace(shadows=shadows[0], casts=shadows[1]),
        )
        pixels: Bytes = kernels.to_pixels(samples, self._encoding)
        return pixels

    def _static_surfaces(self) -> Surfaces:
        """Ground and things at twice the size."""
        scene = self.scene
        camera = self.whole.camera(scene.camera, 2, border=2)
        depth, albedo = ground_seen(scene, camera)
        normal = np.empty((*depth.shape, 3), dtype=np.float32)
        normal[...] = scene.up
        surfaces = Surfaces(depth, normal, albedo, np.zeros_like(depth))
        seen = render(camera, item_bodies(scene), normals=True)
        colors = np.array([item.color_rgb[::-1] for item in scene.items], dtype=np.uint8)
        gloss = np.array([item.gloss for item in scene.items], dtype=np.float32)
        surfaces.cover(seen, linear(colors), gloss)
        return surfaces


class LampCamera:
    """A lamp as a camera that looks down at the working place."""

    def __init__(self, lamp: Lamp, scene: Scene, half_width_m: float) -> None:
        target = (0.0, 0.06, 0.0)
        self._light_from_world = looking_at(lamp.position_m, target)
        distance = float(np.linalg.norm(np.array(lamp.position_m) - target))
        focal = _MAP_PX / 2 * distance / half_width_m
        middle = (_MAP_PX - 1) / 2
        self.camera = PinholeCamera(_MAP_PX, _MAP_PX, focal, focal, middle, middle)
        self.light_from_camera = self._light_from_world @ scene.camera_from_world.inverse()
        # The nearest that a surface comes to the lamp decides how far its blockers can be.
        reach_px = kernels.search_radius_px(lamp.diameter_m, focal / (distance - 0.3)) + 1
        self._reach = np.ones((2 * round(reach_px) + 1,) * 2, dtype=np.uint8)

    def shadow(self, bodies: Sequence[tuple[Mesh, Pose]]) -> tuple[Singles, Bytes]:
        """What the lamp sees of bodies, given with `world_from_body`.

        Returns:
            Depth (H, W), m, 0 is nothing; and (H, W), not 0 where a body is in reach.
        """
        seen = [(mesh, self._light_from_world @ pose) for mesh, pose in bodies]
        picture = render(self.camera, seen)
        return picture.depth, cv2.dilate(picture.part_id, self._reach).astype(np.uint8)


def item_bodies(scene: Scene) -> list[tuple[Mesh, Pose]]:
    """The things on the bench with `camera_from_body`."""
    return [(item.mesh, scene.camera_from_world @ item.world_from_body) for item in scene.items]


def _static_depth(scene: Scene, camera: PinholeCamera) -> Singles:
    """(H, W) depth of ground and things, m."""
    depth, _ = ground_seen(scene, camera)
    seen = render(camera, item_bodies(scene)).depth
    nearer: Singles = np.where((seen > 0) & (seen < depth), seen, depth)
    return nearer


def kernel_lamps(
    scene: Scene,
    lamps: Sequence[Lamp],
    ambient: Array,
    views: Sequence[LampCamera],
    shadows: Singles,
    casts: Bytes,
) -> kernels.Lamps:
    """Lamps for the kernels; `views` go once or more through all lamps."""
    positions = [np.array(lamp.position_m) for lamp in lamps]
    rows = [
        [*scene.camera_from_world.transform(position), lamp.diameter_m, *lamp.intensity]
        for position, lamp in zip(positions, lamps, strict=True)
    ]
    return kernels.Lamps(
        rows=np.array(rows),
        ambient=ambient,
        up=np.array(scene.up),
        map_lamp=np.arange(len(views)) % len(rows),
        lamp_from_camera=np.stack([view.light_from_camera.matrix for view in views]),
        lenses=np.stack([intrinsics_of(view.camera) for view in views]),
        shadows=shadows,
        casts=casts,
        taps=np.concatenate([_disc(kernels.SEARCH_TAPS), _disc(kernels.FILTER_TAPS)]),
    )


def _disc(n: int) -> Array:
    """(n, 2) points spread evenly over the unit disc (Vogel's spiral)."""
    index = np.arange(n)
    reach, angle = np.sqrt((index + 0.5) / n), 2.399963 * index
    return np.column_stack([reach * np.cos(angle), reach * np.sin(angle)])


def encoding() -> Bytes:
    """Bytes of sRGB for 4096 equal steps of the square root of light (IEC 61966-2-1)."""
    light = np.linspace(0, 1, 4096) ** 2
    srgb = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    table: Bytes = np.clip(srgb * 255 + 0.5, 0, 255).astype(np.uint8)
    return table
