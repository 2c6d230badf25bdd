"""Finds parts by their shape alone, in the depth image: no network, no training.

What rises above the bench is cut into clusters; views of the sparse viewpoint models are laid over
them; the best are refined by the tracker's optimiser and judged by its likelihood. A part is
reported only where nearly all agrees.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.clusters import Cluster, find_clusters
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.fits import Fit, in_order, shapes
from snapfit.tracking.finding.open3d_module import open3d
from snapfit.tracking.finding.parameters import GeometricParameters
from snapfit.tracking.finding.plane import Plane, find_plane, rises
from snapfit.tracking.finding.point_cloud import PointCloud, point_cloud
from snapfit.tracking.finding.proposals import PartViews
from snapfit.tracking.finding.scoring import Refined, Scorer
from snapfit.tracking.frame import Frame, check_frame

_LARGER = 1.25
_FIRST_MARGINS_PX = (4.0, 2.0)
_LAST_MARGINS_PX = (2.0,) * 6
_SETTLED = 2
_HOPELESS = 0.35


@dataclass(frozen=True, eq=False)
class Scene:
    """What a frame holds."""

    frame: Frame
    cloud: PointCloud
    plane: Plane | None
    clusters: Sequence[Cluster]


class GeometricFinder:
    """Finds parts by depth; see `Finder`.

    A cluster is taken for one part: joined parts are not told apart.

    Attributes:
        names: of the parts.
        camera: where the frames come from.
        rejected: poses that were not convincing, by reason; counted since it was made.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        camera: RgbdCamera,
        parameters: GeometricParameters | None = None,
    ) -> None:
        """Makes ready.

        Args:
            bodies: the parts, with their viewpoint models.
            camera: where the frames come from.
            parameters: of all steps.

        Raises:
            TrackingError: there is no depth camera, no part, or no Open3D.
        """
        if camera.depth is None:
            raise TrackingError(
                "the geometric detector needs a depth camera, this one has colour alone: train a "
                "network (`snapfit train`), or give the first poses"
            )
        if not bodies:
            raise TrackingError("the geometric detector has no part to find")
        open3d()
        self._parameters = parameters or GeometricParameters()
        self.names = tuple(body.name for body in bodies)
        self.camera = camera
        self.rejected: Counter[str] = Counter()
        self._depth_camera = camera.depth
        self._depth_from_color = camera.color_from_depth.inverse()
        self._bodies = {body.name: body for body in bodies}
        self._shapes = shapes(bodies)
        self._views = {body.name: PartViews(body, self._parameters.proposals) for body in bodies}
        self._scorers = {body.name: Scorer(body, camera) for body in bodies}

    def find(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> list[Hypothesis]:
        """Look for parts, each by itself; see `Finder.find`. Without depth none is found.

        Raises:
            FrameError: the frame does not fit the camera.
            TrackingError: a part that this finder does not know.
        """
        del known  # each cluster is looked at by itself
        check_frame(frame, self.camera)
        for name in wanted:
            if name not in self._bodies:
                names = ", ".join(self.names)
                raise TrackingError(f"there is no part {name!r} to find; the parts are {names}")
        sought = [name for name in self.names if name in wanted]
        scene = self._scene(frame) if sought else None
        if scene is None:
            return []
        fits: list[Fit] = []
        for shape in dict.fromkeys(self._shapes[name] for name in sought):
            alike = [name for name in sought if self._shapes[name] == shape]
            found = self._fits(scene, alike[0])
            fits += [replace(fit, part=name) for name in alike for fit in found]
        return in_order(fits)

    def _scene(self, frame: Frame) -> Scene | None:
        """The clusters that may be one of the parts; None without depth."""
        if frame.depth is None:
            return None
        p = self._parameters.cloud
        scale_m = self.camera.depth_scale_m
        cloud = point_cloud(frame.depth, self._depth_camera, scale_m, p.stride_px, p.farthest_m)
        largest_m = max(self._largest_m(name) for name in self.names)
        plane = find_plane(cloud, p, largest_m)
        clusters = find_clusters(cloud, rises(cloud, plane, p), p, largest_m)
        return Scene(frame, cloud, plane, clusters)

    def _largest_m(self, name: str) -> float:
        return _LARGER * self._bodies[name].mesh.diameter_m

    def _fits(self, scene: Scene, name: str) -> list[Fit]:
        """Convincing poses of a part, one a cluster; those of its like are the same."""
        scorer = self._scorers[name]
        scorer.see(scene.frame)
        tried = []
        for cluster, pose in self._proposals(scene, name):
            found = scorer.refine(pose, _FIRST_MARGINS_PX, scene.cloud, cluster)
            if found is not None and found.score > _HOPELESS:
                tried.append((cluster, found))
        tried.sort(key=lambda each: -each[1].worth)
        best: dict[frozenset[int], Refined] = {}
        settled: Counter[frozenset[int]] = Counter()
        for cluster, first in tried:
            settled[cluster.pieces] += 1
            if settled[cluster.pieces] > _SETTLED:
                continue
            pose = first.camera_from_body
            found = scorer.refine(pose, _LAST_MARGINS_PX, scene.cloud, cluster)
            known = best.get(cluster.pieces)
            if found is not None and (known is None or found.worth > known.worth):
                best[cluster.pieces] = found
        convincing = []
        for pieces, found in best.items():
            if (objection := self._objection(scene, name, found)) is None:
                convincing.append(Fit(name, self._shapes[name], pieces, found))
            else:
                self.rejected[objection] += 1
        return convincing

    def _proposals(self, scene: Scene, name: str) -> list[tuple[Cluster, Pose]]:
        """Poses of a part that are worth refining, `camera_from_body`, with what they explain."""
        p, views = self._parameters, self._views[name]
        proposed = []
        for cluster in scene.clusters:
            if cluster.extent_m < self._largest_m(name):
                found = views.propose(scene.cloud, scene.plane, cluster)
                if found:
                    proposed.append((cluster, found))
        proposed.sort(key=lambda each: each[1][0].error_m)
        likely = [
            (each.error_m, cluster, self.camera.color_from_depth @ each.depth_from_body)
            for cluster, found in proposed[: p.tried_clusters]
            for each in found
        ]
        likely.sort(key=lambda each: each[0])
        return [(cluster, pose) for _, cluster, pose in likely[: p.tried]]

    def _objection(self, scene: Scene, name: str, found: Refined) -> str | None:
        """Why a pose cannot be told, None if it can: false ones are worse than none."""
        p, evidence = self._parameters, found.evidence
        if scene.plane is not None:
            pose = self._depth_from_color @ found.camera_from_body
            heights_m = scene.plane.heights_m(pose.transform(self._bodies[name].mesh.vertices))
            if heights_m.min() < -p.deepest_m:
                return "below_bench"
        if evidence.lines + evidence.points < p.least_evidence:
            return "little_evidence"
        return None if found.score >= p.least_score else "low_score"
