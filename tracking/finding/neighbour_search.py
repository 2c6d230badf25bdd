"""Looks where the assembly's links put a part, beside parts that are known.

A place is told where the depth image shows something that the known parts do not explain, and the
tracker's optimiser agrees with it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Asset
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import Rendering, render
from snapfit.models.symmetry import distance_modulo_symmetry
from snapfit.tracking.body import Body
from snapfit.tracking.finding.among import AmongOthers
from snapfit.tracking.finding.assignment import Assignment
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.link_places import LinkPlaces
from snapfit.tracking.finding.parameters import JoinedParameters
from snapfit.tracking.finding.plane import find_plane, rises
from snapfit.tracking.finding.point_cloud import PointCloud, point_cloud
from snapfit.tracking.finding.scoring import drawn_window
from snapfit.tracking.finding.twins import Twins
from snapfit.tracking.frame import Frame

_HIDDEN_M = 0.003
_CORNERS = 60


@dataclass(frozen=True, eq=False)
class _Scene:
    """What a frame holds.

    Attributes:
        frame: itself.
        there: `camera_from_body` of the known parts.
        cloud: its points.
        stands: (h, w) those of them that rise above the bench.
        known: (h, w) depth of the known parts, m, 0 where none is.
    """

    frame: Frame
    there: Mapping[str, Pose]
    cloud: PointCloud
    stands: npt.NDArray[np.bool_]
    known: npt.NDArray[np.float32]


class NeighbourSearch:
    """Looks for parts beside their neighbours; from one thread at a time.

    Args:
        bodies: the tracked parts, with their viewpoint models.
        camera: where the frames come from.
        asset: whose states say how parts are linked.
        parameters: of all steps.

    Attributes:
        assignment: says of which parts two cannot be at one place.
        twins: says which of several parts of one mesh is which.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        camera: RgbdCamera,
        asset: Asset,
        parameters: JoinedParameters | None = None,
    ) -> None:
        self.assignment = Assignment(bodies)
        self._camera = camera
        self._parameters = parameters or JoinedParameters()
        self._bodies = {body.name: body for body in bodies}
        self._symmetries = {part.name: part.symmetry for part in asset.parts}
        self._places = LinkPlaces(asset.tracked_parts, asset.states)
        self.twins = Twins(asset.tracked_parts, self._places, self.assignment)
        self._among = AmongOthers(bodies, camera)
        self._depth_from_color = camera.color_from_depth.inverse()
        self._largest_m = max(body.mesh.diameter_m for body in bodies)

    def beside(
        self, frame: Frame, missing: Sequence[str], there: Mapping[str, Pose]
    ) -> list[Hypothesis]:
        """Those of the missing parts that sit on one of those that are there; none without depth.

        Their scores are the shares of what is seen that lies where depth is measured.

        Args:
            frame: in which they are looked for.
            missing: names of the parts.
            there: `camera_from_body` of the others, as far as they are known.
        """
        likely = {name: poses for name in missing if (poses := self._places.of(name, there))}
        scene = self._scene(frame, there) if likely else None
        if scene is None:
            return []
        told = [
            found
            for name, poses in likely.items()
            if (found := self._surest(scene, name, poses)) is not None
        ]
        placed = self.assignment.assign(told, missing, there)
        # A twin may sit where another one was looked for: the part that a link names stays its own.
        return [each for each in told if placed.get(each.part) is each.camera_from_body]

    def _scene(self, frame: Frame, there: Mapping[str, Pose]) -> _Scene | None:
        """What the depth image holds; None without one."""
        depth, camera, p = frame.depth, self._camera, self._parameters.cloud
        if depth is None or camera.depth is None:
            return None
        cloud = point_cloud(depth, camera.depth, camera.depth_scale_m, p.stride_px, p.farthest_m)
        stands = rises(cloud, find_plane(cloud, p, self._largest_m), p)
        return _Scene(frame, there, cloud, stands, self._drawn(cloud, there).depth)

    def _drawn(self, cloud: PointCloud, there: Mapping[str, Pose]) -> Rendering:
        """Parts as the cloud's camera would see them alone."""
        bodies = [
            (self._bodies[name].mesh, self._depth_from_color @ pose) for name, pose in there.items()
        ]
        return render(cloud.camera, bodies)

    def _surest(self, scene: _Scene, name: str, poses: Sequence[Pose]) -> Hypothesis | None:
        """A part in the place that fits best, refined; None where nothing speaks for it."""
        p = self._parameters
        poses = self._not_seen_through(scene, name, poses)
        if not poses:
            return None
        fits = [self._fit(scene, name, pose) for pose in poses]
        best = int(np.argmax(fits))
        if fits[best] < p.least_fit:
            return None
        settled = self._among.settle(scene.frame, name, poses[best], scene.there)
        if settled is None or settled.evidence.confidence < p.least_confidence:
            return None
        near = self._near(poses[best], settled.camera_from_body, name)
        fits = [self._fit(scene, name, pose, p.close_m) for pose in near]
        score = max(fits)
        if score < p.least_close:
            return None
        return Hypothesis(name, near[fits.index(score)], score, is_refined=True)

    def _not_seen_through(self, scene: _Scene, name: str, poses: Sequence[Pose]) -> list[Pose]:
        """The places that the camera does not see through: a quick test of the mesh's corners."""
        p, camera = self._parameters, scene.cloud.camera
        vertices = self._bodies[name].mesh.vertices
        corners = vertices[:: max(1, len(vertices) // _CORNERS)]
        placed = np.stack([(self._depth_from_color @ pose).transform(corners) for pose in poses])
        poses = [pose for pose, z in zip(poses, placed[..., 2], strict=True) if z.min() > 0]
        placed = placed[placed[..., 2].min(axis=1) > 0]
        columns, rows = np.rint(camera.project(placed.reshape(-1, 3))).astype(np.int64).T
        z = placed[..., 2]
        inside = (columns >= 0) & (columns < camera.width) & (rows >= 0) & (rows < camera.height)
        measured = np.zeros(len(columns))
        measured[inside] = scene.cloud.depth_m[rows[inside], columns[inside]]
        is_through = (measured.reshape(z.shape) - z > p.through_m).mean(axis=1)
        return [pose for pose, share in zip(poses, is_through, strict=True) if share < p.through]

    def _near(self, place: Pose, refined: Pose, name: str) -> list[Pose]:
        """The refined pose, and the place itself; the former not where it has been led astray."""
        p = self._parameters
        off_m, off_rad = distance_modulo_symmetry(place, refined, self._symmetries[name])
        return [refined, place] if off_m < p.stays_m and off_rad < p.stays_rad else [place]

    def _fit(self, scene: _Scene, name: str, pose: Pose, agrees_m: float | None = None) -> float:
        """Share of a part's seen surface that lies where depth is measured, 0 to 1.

        0 where too little of it can be seen, or where the known parts and the bench explain what
        is measured as well.
        """
        drawn = self._drawn(scene.cloud, {name: pose})
        p, window = self._parameters, drawn_window(drawn)
        if window is None:
            return 0.0
        z, known = drawn.depth[window], scene.known[window]
        measured, stands = scene.cloud.depth_m[window], scene.stands[window]
        is_seen = (z > 0) & ~((known > 0) & (known < z - _HIDDEN_M))
        behind = measured - z
        # Something unknown that is nearer may hide it.
        asked = is_seen & (measured > 0) & (behind >= -p.agrees_m)
        n_asked = int(asked.sum())
        if n_asked < p.least_pixels or n_asked < p.least_seen * int(is_seen.sum()):
            return 0.0
        agrees = asked & (np.abs(behind) <= (agrees_m or p.agrees_m))
        other = (known == 0) | (np.abs(known - measured) > p.differs_m)
        n_agrees = int(agrees.sum())
        if int((agrees & other & stands).sum()) < p.least_needed * n_agrees:
            return 0.0
        return n_agrees / n_asked
