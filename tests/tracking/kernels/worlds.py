"""A small rendered world for the kernel that refines: two boxes before a wall."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import trimesh
from scenes import Array, bodies_at, both_cameras

from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.models.viewpoint_build import build_viewpoint_model
from snapfit.tracking.body import Body, pack_models
from snapfit.tracking.depth_modality import depth_settings, empty_points
from snapfit.tracking.kernels.refine import refine
from snapfit.tracking.kernels.types import Bodies, Images, Lines, Models, Points
from snapfit.tracking.kinematics import KinematicStructures
from snapfit.tracking.nearby import occlusion_settings
from snapfit.tracking.parameters import DepthParameters, OcclusionParameters, RegionParameters
from snapfit.tracking.region_modality import empty_lines, region_settings

WORLD_CAMERA = PinholeCamera(320, 240, fx=300.0, fy=300.0, cx=160.3, cy=119.1)
WALL_M = 1.1
COLORS_BGR = np.array([[40, 170, 60], [200, 60, 40], [50, 50, 220]])
ITERATIONS = 5
LINES_MAX = POINTS_MAX = 150
# Of the tests themselves, so that tuning the trackers' does not touch them.
REGION = RegionParameters(
    lines_max=LINES_MAX,
    scales_px=(6, 4, 2, 1),
    standard_deviations_px=(15.0, 5.0, 3.5, 1.5),
    outlying=1.5,
)
DEPTH = DepthParameters(
    points_max=POINTS_MAX,
    considered_distances_m=(0.05, 0.02, 0.01),
    standard_deviations_m=(0.05, 0.03, 0.01, 0.008),
    strides_m=(0.01, 0.005),
)


@dataclass(frozen=True, eq=False)
class Refined:
    """The state of all bodies after a refinement."""

    bodies: Bodies
    lines: Lines
    points: Points
    counts: Array

    @property
    def poses(self) -> list[Pose]:
        """`camera_from_body` of each body."""
        return [Pose(matrix) for matrix in self.bodies.poses]


@dataclass(frozen=True, eq=False)
class World:
    """What is seen of two boxes at known poses, by colour and depth."""

    known: Sequence[Body]  # the models hold addresses in these
    models: Models
    truth: tuple[Pose, ...]
    images: Images
    tables: Array
    parameters: OcclusionParameters = field(
        default_factory=lambda: OcclusionParameters(modelled=False)
    )

    def refine(
        self,
        poses: Sequence[Pose],
        *,
        iterations: int = ITERATIONS,
        updates: int = 2,
        n_parts: int = 4,
        active: Sequence[int] | None = None,
        tikhonov: tuple[float, float] = (1000.0, 30000.0),
    ) -> Refined:
        """Refine both bodies from some poses, or those that are active."""
        bodies = bodies_at(list(poses), self.tables)
        bodies.active[:] = 1 if active is None else active
        n = len(bodies.poses)
        lines, points = empty_lines(n, LINES_MAX), empty_points(n, POINTS_MAX)
        counts = np.full((n, n_parts, 2, 4), -1)
        refine(
            iterations,
            updates,
            n_parts,
            self.images,
            both_cameras(WORLD_CAMERA, WORLD_CAMERA),
            self.models,
            bodies,
            KinematicStructures(n).arrays,
            region_settings(REGION, ITERATIONS),
            depth_settings(DEPTH, ITERATIONS),
            occlusion_settings(self.parameters, has_depth=True),
            np.array(tikhonov),
            lines,
            points,
            counts,
        )
        return Refined(bodies, lines, points, counts)

    def near(self, rng: np.random.Generator, size: float = 1.0) -> list[Pose]:
        """Poses some 5 mm and 3 degrees beside the true ones."""
        scale = size * np.array([0.03] * 3 + [0.003] * 3)
        return [pose.perturbed(scale * rng.normal(size=6)) for pose in self.truth]


def make_world() -> World:
    """Two boxes side by side; takes about a second."""
    boxes = [trimesh.creation.box(size) for size in ([0.15, 0.09, 0.04], [0.08, 0.05, 0.12])]
    meshes = [Mesh(box.vertices, box.faces) for box in boxes]
    bodies = [Body("box", mesh, build_viewpoint_model(mesh, n_divisions=2)) for mesh in meshes]
    turns = Pose.exp([2.4, 0.5, 0.3, 0, 0, 0]), Pose.exp([0.7, -0.6, 1.1, 0, 0, 0])
    places = Pose.from_translation(-0.1, 0.01, 0.55), Pose.from_translation(0.12, -0.02, 0.62)
    poses = tuple(place @ turn for place, turn in zip(places, turns, strict=True))
    picture = render(WORLD_CAMERA, list(zip(meshes, poses, strict=True)))
    rng = np.random.default_rng(11)
    color = COLORS_BGR[picture.part_id] + rng.normal(scale=12, size=(*picture.depth.shape, 3))
    depth_m = np.where(picture.depth > 0, picture.depth, WALL_M)
    color = np.clip(color, 0, 255).astype(np.uint8)
    images = Images(
        color=color,
        depth=np.round(depth_m * 1000).astype(np.uint16),
        near_depth=np.zeros((1, 1), dtype=np.float32),
        near_id=np.zeros((1, 1), dtype=np.uint8),
        neighboured=np.zeros(2, dtype=np.uint8),
        alike=np.zeros((2, 2), dtype=np.uint8),
        hiding=np.full(2, 0.035, dtype=np.float32),
    )
    tables = np.array([_table(color, picture.part_id == i + 1) for i in range(2)])
    models = pack_models(bodies, LINES_MAX, POINTS_MAX)
    return World(bodies, models, poses, images, tables)


def _table(color: Array, mask: Array) -> Array:
    """(4096,) posterior of the foreground by colour, as the image itself has it."""
    bins = (color.astype(np.int64) // 16) @ [256, 16, 1]
    inside = np.bincount(bins[mask], minlength=4096) / mask.sum()
    outside = np.bincount(bins[~mask], minlength=4096) / (~mask).sum()
    total = inside + outside
    return np.divide(inside, total, out=np.full(4096, 0.5), where=total > 0)
