"""Finds parts by network and shape: the network says which part is where, depth how it lies.

The boxes that the network puts around parts are cut out of the depth image; views of the sparse
viewpoint models are fitted into them; the best are refined by the tracker's optimiser, and judged
as in `verdict`. So joined parts are found too, and parts in a hand.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from snapfit.models.camera import RgbdCamera
from snapfit.models.errors import DetectorError
from snapfit.models.pose import Array, Pose
from snapfit.tracking.body import Body
from snapfit.tracking.detection.candidates import overlaps
from snapfit.tracking.detection.detector import Detection, Detector
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.box_views import BoxViews
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.fits import Fit, Found, in_order, shapes
from snapfit.tracking.finding.open3d_module import open3d
from snapfit.tracking.finding.parameters import GuidedParameters
from snapfit.tracking.finding.plane import Plane, find_plane, rises
from snapfit.tracking.finding.point_cloud import PointCloud, point_cloud
from snapfit.tracking.finding.regions import Region, RegionMap
from snapfit.tracking.finding.scoring import Scorer
from snapfit.tracking.finding.verdict import Verdict, judged
from snapfit.tracking.frame import Frame, check_frame
from snapfit.tracking.recovery.taken import TakenPlaces

_FIRST_MARGINS_PX = (4.0, 2.0)
_LAST_MARGINS_PX = (2.0,) * 4
_SETTLED, _CLOSE_M, _CLOSE_RAD = 2, 0.003, 0.05
_SAME_BOX = 0.8


@dataclass(frozen=True, eq=False)
class _Scene:
    """What a frame holds."""

    frame: Frame
    cloud: PointCloud
    plane: Plane | None
    regions: RegionMap


class GuidedFinder:
    """Finds parts where a network sees them; see `Finder`.

    Without depth in a frame, it tells the network's own poses.

    Attributes:
        names: of the parts that the network knows.
        camera: where the frames come from.
        provider: of ONNX Runtime that runs the network.
        rejected: candidates that were not told, by reason; counted since it was made.
    """

    def __init__(
        self,
        detector: Detector,
        bodies: Sequence[Body],
        camera: RgbdCamera,
        parameters: GuidedParameters | None = None,
    ) -> None:
        """Makes ready.

        Args:
            detector: the network.
            bodies: the parts, with their viewpoint models.
            camera: where the frames come from.
            parameters: of all steps but the network's.

        Raises:
            TrackingError: there is no Open3D, or the network knows none of the bodies.
        """
        p = self._parameters = parameters or GuidedParameters()
        known = [body for body in bodies if body.name in detector.names]
        if not known:
            raise TrackingError(f"the network finds none of {[body.name for body in bodies]}")
        if camera.depth is not None:
            open3d()
        self._detector, self._rejected = detector, Counter[str]()
        self.camera, self.provider = camera, detector.provider
        self.names = tuple(body.name for body in known)
        self._bodies = tuple(known)
        self._index = {name: i for i, name in enumerate(self.names)}
        self._taken = TakenPlaces(known)
        self._shapes = shapes(known)
        self._depth_from_color = camera.color_from_depth.inverse()
        self._largest_m = max(body.mesh.diameter_m for body in known)
        # Parts of one mesh share what is made of it.
        first = {self._shapes[body.name]: body for body in reversed(known)}
        self._views = {shape: BoxViews(body, p.views, p.box) for shape, body in first.items()}
        self._scorers = {shape: Scorer(body, camera) for shape, body in first.items()}

    @property
    def rejected(self) -> Mapping[str, int]:
        """Candidates that were not told since it was made, by reason."""
        return self._rejected + Counter(self._detector.rejected)

    def find(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> list[Hypothesis]:
        """Look for parts; only those that are wanted cost time. See `Finder.find`.

        Raises:
            FrameError: the frame does not fit the camera.
            TrackingError: a part that this finder does not know, or the network does not run.
        """
        del known  # each candidate is looked at by itself
        unknown = sorted(set(wanted) - set(self.names))
        if unknown:
            raise TrackingError(f"this finder finds {', '.join(self.names)}, not {unknown[0]!r}")
        names = [name for name in self.names if name in wanted]
        if not names:
            return []
        check_frame(frame, self.camera)
        scene = self._scene(frame)
        if scene is None:
            return self._detector.find(frame, wanted)
        try:
            detections = self._detector.detect(frame)
        except DetectorError as error:
            raise TrackingError(str(error)) from error
        fits: list[Fit] = []
        for shape in dict.fromkeys(self._shapes[name] for name in names):
            candidates = [each for each in detections.found if self._shapes.get(each.part) == shape]
            candidates.sort(key=lambda each: -each.score)
            alike = [name for name in names if self._shapes[name] == shape]
            for found in self._convincing(scene, shape, candidates):
                fits += [Fit(name, shape, frozenset(), found) for name in alike]
        return in_order(self._at_places(fits))

    def _scene(self, frame: Frame) -> _Scene | None:
        """What the depth image holds; None without one."""
        depth, camera, p = frame.depth, self.camera, self._parameters.cloud
        if depth is None or camera.depth is None:
            return None
        cloud = point_cloud(depth, camera.depth, camera.depth_scale_m, p.stride_px, p.farthest_m)
        plane = find_plane(cloud, p, self._largest_m)
        return _Scene(frame, cloud, plane, RegionMap(cloud, rises(cloud, plane, p), camera))

    def _convincing(
        self, scene: _Scene, shape: int, candidates: Sequence[Detection]
    ) -> list[Verdict]:
        """Convincing poses of parts of one mesh, each at a place of its own."""
        alike = [name for name, each in self._shapes.items() if each == shape]
        body = self._index[alike[0]]
        self._scorers[shape].see(scene.frame)
        told: list[Verdict] = []
        boxes: list[Array] = []
        for each in candidates:
            if len(told) == len(alike):
                break
            # Each of several classes of one mesh has its box around the same thing.
            if boxes and overlaps(each.box_px, np.stack(boxes)).max() > _SAME_BOX:
                continue
            boxes.append(each.box_px)
            found = self._found(scene, each, shape, self._bodies[body])
            if isinstance(found, str):
                self._rejected[found] += 1
            elif not any(self._is_same(body, found, body, other) for other in told):
                told.append(found)
        return told

    def _found(self, scene: _Scene, candidate: Detection, shape: int, body: Body) -> Verdict | str:
        """A convincing pose for a candidate of the network; or why there is none."""
        reason = "no_fit"
        for region in self._regions(scene, candidate):
            best = self._best(scene, region, shape)
            if best is None:
                continue
            objection = self._objection(scene, body, best)
            if objection is None:
                return best
            reason = objection
        return reason

    def _regions(self, scene: _Scene, candidate: Detection) -> Iterator[Region]:
        """The region of a candidate; then the same as that of its visible piece alone."""
        region = scene.regions.cut(candidate.box_px, candidate.score)
        if region is None:
            return
        yield region
        if candidate.score >= self._parameters.open_score:
            opened = scene.regions.opened(region)
            if opened is not None:
                yield opened

    def _best(self, scene: _Scene, region: Region, shape: int) -> Verdict | None:
        """The surest pose in a region; None where no view fits."""
        p = self._parameters
        proposed = self._views[shape].propose_in(scene.cloud, scene.plane, region)
        tried: list[Verdict] = []
        for each in proposed:
            if len(tried) >= p.least_tried and max(t.score for t in tried) >= p.clear_score:
                break
            pose = self.camera.color_from_depth @ each.depth_from_body
            tried += self._judged(scene, region, shape, pose, _FIRST_MARGINS_PX)
        tried.sort(key=lambda each: -each.score)
        if not tried or tried[0].score < p.hopeless_score:
            return None
        # Neighbours have mostly met at one pose.
        others = [each for each in tried[1:_SETTLED] if not _is_close(each, tried[0])]
        settled = [
            verdict
            for each in tried[:1] + others
            for verdict in self._judged(
                scene, region, shape, each.camera_from_body, _LAST_MARGINS_PX
            )
        ]
        return max(settled, key=lambda each: each.score, default=None)

    def _judged(
        self, scene: _Scene, region: Region, shape: int, pose: Pose, margins_px: Sequence[float]
    ) -> list[Verdict]:
        """What becomes of a pose; nothing where the refinement has no solution."""
        scorer = self._scorers[shape]
        settled = scorer.settle(pose, margins_px)
        if settled is None:
            return []
        drawn = scorer.drawn(settled.camera_from_body, scene.cloud)
        return [judged(settled, drawn, scene.cloud, region)]

    def _objection(self, scene: _Scene, body: Body, found: Verdict) -> str | None:
        """Why a pose cannot be told, None if it can: false ones are worse than none."""
        p, evidence = self._parameters, found.evidence
        pose = self._depth_from_color @ found.camera_from_body
        if scene.plane is not None:
            lowest_m = scene.plane.heights_m(pose.transform(body.mesh.vertices)).min()
            if lowest_m < -p.deepest_m:
                return "below_bench"
        if evidence.lines + evidence.points < p.least_evidence:
            return "little_evidence"
        return None if found.score >= p.least_score else "low_score"

    def _at_places(self, fits: Sequence[Fit]) -> list[Fit]:
        """Fits with the number of their place: of two parts at one place one is wrong."""
        ordered = sorted(fits, key=lambda each: -each.found.score)
        placed: list[Fit] = []
        for fit in ordered:
            body = self._index[fit.part]
            same = (
                other.pieces
                for other in placed
                if self._is_same(body, fit.found, self._index[other.part], other.found)
            )
            placed.append(replace(fit, pieces=next(same, frozenset([len(placed)]))))
        return placed

    def _is_same(self, body: int, found: Found, other: int, known: Found) -> bool:
        """Whether a body lies where another one does."""
        return self._taken.lies_in(body, found.camera_from_body, other, known.camera_from_body)


def _is_close(one: Verdict, other: Verdict) -> bool:
    a, b = one.camera_from_body, other.camera_from_body
    return bool(a.distance_to(b) < _CLOSE_M and a.angle_to(b) < _CLOSE_RAD)
