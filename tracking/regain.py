"""Finds parts again that were lost or hidden: poses are proposed, tried out, the likeliest kept.

Proposals lie where the part's colours are seen and no other part explains them, with the last
rotation and with others. Only few are tried in a frame, so that no frame takes long; the search
goes on in the next.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Array, Pose
from snapfit.tracking.body import Body
from snapfit.tracking.frame import Frame
from snapfit.tracking.optimiser import Attempt, Optimiser
from snapfit.tracking.seen_through import SeenThrough

_GRID_PX = 8
_FOREGROUND = 0.65
_BLOBS_MAX = 3
_LEAST_CELLS = 4
_USUAL, _DOUBTFUL, _BACK = 0.85, 0.45, 0.4
_FORESHORTENED, _LONG = 0.5, 0.5
_TURNS_RAD, _HALF_TURNS = 1.2, 0.3
_CLIMB, _AGEING, _JITTER_RAD, _JITTER_M = 0.6, 0.97, 0.12, 0.006
_POINTS, _FEW = 400, 60
_SAME_SURFACE, _TAKEN = 0.16, 0.7


@dataclass(frozen=True)
class RegainParameters:
    """How parts are looked for.

    Attributes:
        tries: poses tried out in a frame, for all parts together.
        convincing: confidence that a found pose needs.
        least_evidence: lines and points that it needs.
    """

    tries: int = 3
    convincing: float = 0.7
    least_evidence: int = 120


@dataclass(frozen=True, eq=False)
class Place:
    """Where colours of a body are seen.

    Attributes:
        middle: (3,) m, camera frame.
        direction_rad: in which it is long, from the image's x axis; None if in no one.
    """

    middle: Array
    direction_rad: float | None


@dataclass(frozen=True, eq=False)
class Wanted:
    """A body that is looked for.

    Attributes:
        expected: `camera_from_body` where it was seen last, or was carried to.
        left: where it was seen last.
        unseen_frames: since it was seen.
        usual_confidence: of its pose, when all is well.
    """

    expected: Pose
    left: Pose
    unseen_frames: int
    usual_confidence: float

    @property
    def reach_m(self) -> float:
        """How far it may have gone: hands move parts by some 3 mm a frame, 10 mm at most."""
        return min(0.03 + 0.006 * self.unseen_frames, 0.25)

    @property
    def reach_rad(self) -> float:
        """How far it may have turned."""
        return min(0.35 + 0.05 * self.unseen_frames, np.pi)


class Regainer:
    """Looks for parts through the frames of one camera.

    Args:
        bodies: all that are tracked.
        camera: where the frames come from.
        optimiser: tries poses out.
        seen_through: refutes them by the depth image.
        parameters: how.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        camera: RgbdCamera,
        optimiser: Optimiser,
        seen_through: SeenThrough,
        parameters: RegainParameters | None = None,
    ) -> None:
        self._camera, self._optimiser, self._seen_through = camera, optimiser, seen_through
        self._parameters = parameters or RegainParameters()
        self._centers = [np.asarray(body.mesh.center_m, dtype=np.float64) for body in bodies]
        self._radii = [float(body.mesh.radius_m) for body in bodies]
        self._long = [_longest(body) for body in bodies]
        self._surfaces = [_surface(body) for body in bodies]
        # The order of the proposals is the same in each run: it depends on the frames alone.
        self._rng = np.random.default_rng(0)
        self._round = 0
        self._promising: dict[int, Attempt] = {}

    def search(
        self, frame: Frame, wanted: Mapping[int, Wanted], known: Collection[int] = ()
    ) -> dict[int, Attempt]:
        """Look for bodies; returns those that were found, with their poses.

        Args:
            frame: that the optimiser has seen.
            wanted: bodies, and what is known of them.
            known: bodies whose poses are sure: where one of them is, there is no other.
        """
        found: dict[int, Attempt] = {}
        self._promising = {body: best for body, best in self._promising.items() if body in wanted}
        if not wanted:
            self._round = 0
            return found
        bodies = sorted(wanted)
        shares = dict.fromkeys(bodies, self._parameters.tries // len(bodies))
        for i in range(self._parameters.tries % len(bodies)):
            shares[bodies[(self._round + i) % len(bodies)]] += 1
        self._round += 1
        for body, n_tries in shares.items():
            best = self._try(frame, body, wanted[body], n_tries)
            if best is not None and not self._is_taken(body, best.camera_from_body, known):
                found[body] = best
        return found

    def _try(self, frame: Frame, body: int, wanted: Wanted, n_tries: int) -> Attempt | None:
        p, best = self._parameters, None
        known = [self._center(body, pose) for pose in (wanted.expected, wanted.left)]
        least = min(p.convincing, max(_USUAL * wanted.usual_confidence, _DOUBTFUL))
        places = [
            place
            for place in (self._places(frame, body) if n_tries else [])
            if _nearest(place.middle, known) < wanted.reach_m
        ]
        for _ in range(n_tries):
            tried = self._optimiser.attempt(body, self._proposal(body, wanted, places))
            evidence = tried.evidence
            self._remember(body, tried)
            enough = evidence.lines + evidence.points >= p.least_evidence
            good = tried.solved and enough and evidence.confidence >= least
            center = self._center(body, tried.camera_from_body)
            good &= _nearest(center, known) < wanted.reach_m
            good = good and not self._seen_through.contradicts(
                frame, body, tried.camera_from_body, evidence
            )
            if good and (best is None or tried.likelihood > best.likelihood):
                best = tried
        return best

    def _proposal(self, body: int, wanted: Wanted, places: Sequence[Place]) -> Pose:
        """A pose to start from: where it is expected, or at one of the places, turned or not."""
        if body in self._promising and self._rng.random() < _CLIMB:
            return self._jittered(self._promising[body].camera_from_body, body)
        choice, pose = self._rng.random(), wanted.expected
        if self._rng.random() < _BACK:
            pose = wanted.left
        if not places or choice < 0.2:
            return pose if choice < 0.1 else self._turned(pose, body, wanted.reach_rad)
        place = places[int(self._rng.integers(len(places)))]
        if choice < 0.6:
            pose = self._aligned(pose, body, place)
        if choice > 0.4:
            pose = self._turned(pose, body, wanted.reach_rad)
        return Pose.from_translation(*(place.middle - self._center(body, pose))) @ pose

    def _remember(self, body: int, tried: Attempt) -> None:
        """Keep the likeliest pose so far, and go on from there; it ages, for the part may move."""
        best = self._promising.get(body)
        if best is not None:
            best = self._promising[body] = best._replace(likelihood=_AGEING * best.likelihood)
        if tried.solved and tried.likelihood > max(0.0, best.likelihood if best else 0.0):
            self._promising[body] = tried

    def _jittered(self, pose: Pose, body: int) -> Pose:
        """Moved a little, as far as a refinement may come back from."""
        center = Pose.from_translation(*self._centers[body])
        twist = self._rng.standard_normal(6) * np.repeat((_JITTER_RAD, _JITTER_M), 3)
        return pose @ center @ Pose.exp(twist) @ center.inverse()

    def _is_taken(self, body: int, pose: Pose, known: Collection[int]) -> bool:
        """Whether a body would lie in another one: a twin of a part is not the part."""
        points = pose.transform(self._surfaces[body][:_FEW])
        tolerance_m = max(_SAME_SURFACE * self._radii[body], 0.002)
        for other in known:
            other_pose = self._optimiser.pose(other)
            apart = self._center(body, pose) - self._center(other, other_pose)
            if other == body or np.linalg.norm(apart) > self._radii[other]:
                continue
            theirs = other_pose.transform(self._surfaces[other])
            squares = ((points[:, None] - theirs[None]) ** 2).sum(axis=-1).min(axis=1)
            if (squares < tolerance_m**2).mean() > _TAKEN:
                return True
        return False

    def _center(self, body: int, pose: Pose) -> Array:
        center: Array = pose.transform(self._centers[body][None])[0]
        return center

    def _aligned(self, pose: Pose, body: int, place: Place) -> Pose:
        """Turned about the line of sight until it is long where the place is long."""
        long = pose.rotation @ self._long[body]
        if np.hypot(long[0], long[1]) < _FORESHORTENED or place.direction_rad is None:
            return pose
        turn = place.direction_rad - float(np.arctan2(long[1], long[0]))
        turn = (turn + np.pi / 2) % np.pi - np.pi / 2
        center = Pose.from_translation(*self._center(body, pose))
        return center @ Pose.exp([0, 0, turn, 0, 0, 0]) @ center.inverse() @ pose

    def _turned(self, pose: Pose, body: int, reach_rad: float) -> Pose:
        """Turned about the body's middle: anyhow, or half way round about one of its axes."""
        direction = self._rng.standard_normal(3)
        angle = min(_TURNS_RAD, reach_rad) * float(np.sqrt(self._rng.random()))
        if self._rng.random() < _HALF_TURNS:
            direction, angle = np.eye(3)[self._rng.integers(3)], np.pi
        turn = Pose.exp([*(angle * direction / np.linalg.norm(direction)), 0, 0, 0])
        center = Pose.from_translation(*self._centers[body])
        return pose @ center @ turn @ center.inverse()

    def _places(self, frame: Frame, body: int) -> list[Place]:
        """Where the body may be, by its colours; the largest first."""
        color, depth = self._camera.color, self._camera.depth
        first = _GRID_PX // 2
        bins = frame.color[first::_GRID_PX, first::_GRID_PX].astype(np.int64) >> 4
        likely = self._optimiser.tables[body][bins @ np.array([256, 16, 1])] > _FOREGROUND
        near = self._optimiser.nearby_id
        rows, columns = (
            np.minimum((np.arange(n) * _GRID_PX + first) * size // whole, size - 1)
            for n, size, whole in zip(
                likely.shape, near.shape, (color.height, color.width), strict=True
            )
        )
        others = near[np.ix_(rows, columns)]
        likely &= (others == 0) | (others == body + 1)
        if depth is None or frame.depth is None:
            return []
        places = []
        for row, column, direction_rad in _blobs(likely):
            u, v = (column + 0.5) * _GRID_PX, (row + 0.5) * _GRID_PX
            z = self._depth_at(depth, frame.depth, u, v)
            if z > 0:
                ray = np.array([(u - color.cx) / color.fx, (v - color.cy) / color.fy, 1.0])
                places.append(Place(ray * (z + 0.3 * self._radii[body]), direction_rad))
        return places

    def _depth_at(
        self, camera: PinholeCamera, depth: npt.NDArray[np.uint16], u: float, v: float
    ) -> float:
        """Median depth around a place of the colour image, m; 0 where nothing is measured.

        The shift between the two cameras is left out: this is where a search begins.
        """
        color = self._camera.color
        column = int((u - color.cx) / color.fx * camera.fx + camera.cx)
        row = int((v - color.cy) / color.fy * camera.fy + camera.cy)
        window = depth[max(row - 6, 0) : row + 7 : 2, max(column - 6, 0) : column + 7 : 2]
        known = window[(window > 0) & (window < 65535)]
        return float(np.median(known)) * self._camera.depth_scale_m if known.size else 0.0


def _nearest(point: Array, others: Sequence[Array]) -> float:
    return min(float(np.linalg.norm(point - other)) for other in others)


def _surface(body: Body) -> Array:
    """(P, 3) points all over a body's surface, its frame, m."""
    views = body.views
    rng = np.random.default_rng(0)
    chosen = rng.integers(0, views.surface.shape[:2], size=(_POINTS, 2))
    points: Array = views.surface[chosen[:, 0], chosen[:, 1], :3].astype(np.float64) * views.unit_m
    return points


def _longest(body: Body) -> Array:
    """(3,) direction in which a body is longest, its frame."""
    points = np.asarray(body.mesh.vertices, dtype=np.float64)
    _, vectors = np.linalg.eigh(np.cov(points.T))
    longest: Array = vectors[:, -1]
    return longest


def _blobs(likely: npt.NDArray[np.bool_]) -> list[tuple[float, float, float | None]]:
    """Middle (row, column) and direction (rad) of the largest connected regions."""
    n, labels, stats, centroids = cv2.connectedComponentsWithStats(likely.astype(np.uint8))
    sizes = stats[1:n, cv2.CC_STAT_AREA]
    blobs = []
    for i in np.argsort(-sizes)[:_BLOBS_MAX]:
        if sizes[i] >= _LEAST_CELLS:
            rows, columns = np.nonzero(labels == 1 + i)
            x, y = centroids[1 + i]
            blobs.append((float(y), float(x), _direction(rows - y, columns - x)))
    return blobs


def _direction(rows: Array, columns: Array) -> float | None:
    """Direction in which cells are spread, rad from the image's x axis; None if in all alike."""
    xx, yy, xy = float(columns @ columns), float(rows @ rows), float(rows @ columns)
    if np.hypot(xx - yy, 2 * xy) < _LONG * (xx + yy):
        return None
    return float(0.5 * np.arctan2(2 * xy, xx - yy))
