"""Finds parts again that were lost or hidden: poses are proposed, tried out, the likeliest kept.

Proposals lie where the part's colours are seen and no other part explains them, with the last
rotation and with others. Only few are tried in a frame, so that no frame takes long; the search
goes on in the next.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Array, Pose
from snapfit.tracking.body import Body
from snapfit.tracking.frame import Frame
from snapfit.tracking.optimiser import Attempt, Optimiser

_GRID_PX = 8
_FOREGROUND = 0.65
_BLOBS_MAX = 3
_LEAST_CELLS = 4
_TURNS_RAD, _HALF_TURNS = 1.2, 0.3


@dataclass(frozen=True)
class RegainParameters:
    """How parts are looked for.

    Attributes:
        tries: poses tried out in a frame, for all parts together.
        convincing: confidence that a found pose needs.
        least_evidence: lines and points that it needs.
        better: how much likelier than the pose that a part has it must be, logarithm.
    """

    tries: int = 3
    convincing: float = 0.7
    least_evidence: int = 120
    better: float = 60.0


class Regainer:
    """Looks for parts through the frames of one camera.

    Args:
        bodies: all that are tracked.
        camera: where the frames come from.
        optimiser: tries poses out.
        parameters: how.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        camera: RgbdCamera,
        optimiser: Optimiser,
        parameters: RegainParameters | None = None,
    ) -> None:
        self._camera, self._optimiser = camera, optimiser
        self._parameters = parameters or RegainParameters()
        self._centers = [np.asarray(body.mesh.center_m, dtype=np.float64) for body in bodies]
        self._radii = [float(body.mesh.radius_m) for body in bodies]
        # The order of the proposals is the same in each run: it depends on the frames alone.
        self._rng = np.random.default_rng(0)
        self._round = 0

    def search(self, frame: Frame, wanted: Mapping[int, Pose]) -> dict[int, Attempt]:
        """Look for bodies; returns those that were found, with their poses.

        Args:
            frame: that the optimiser has seen.
            wanted: bodies and the last poses that were trusted.
        """
        found: dict[int, Attempt] = {}
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
            if best is not None:
                found[body] = best
        return found

    def _try(self, frame: Frame, body: int, last: Pose, n_tries: int) -> Attempt | None:
        p, best = self._parameters, None
        places = self._places(frame, body) if n_tries else []
        for _ in range(n_tries):
            tried = self._optimiser.attempt(body, self._proposal(body, last, places))
            evidence = tried.evidence
            enough = evidence.lines + evidence.points >= p.least_evidence
            good = tried.solved and enough and evidence.confidence >= p.convincing
            if good and (best is None or tried.likelihood > best.likelihood):
                best = tried
        return best

    def _proposal(self, body: int, last: Pose, places: Sequence[Array]) -> Pose:
        """A pose to start from: the last one, or at one of the places, turned or not."""
        choice = self._rng.random()
        if not places or choice < 0.2:
            return self._turned(last, body) if choice < 0.1 else last
        place = places[int(self._rng.integers(len(places)))]
        pose = last if choice < 0.5 else self._turned(last, body)
        center = pose.transform(self._centers[body][None])[0]
        return Pose.from_translation(*(place - center)) @ pose

    def _turned(self, pose: Pose, body: int) -> Pose:
        """Turned about the body's middle: anyhow, or half way round about one of its axes."""
        direction = self._rng.standard_normal(3)
        angle = _TURNS_RAD * float(np.sqrt(self._rng.random()))
        if self._rng.random() < _HALF_TURNS:
            direction, angle = np.eye(3)[self._rng.integers(3)], np.pi
        turn = Pose.exp([*(angle * direction / np.linalg.norm(direction)), 0, 0, 0])
        center = Pose.from_translation(*self._centers[body])
        return pose @ center @ turn @ center.inverse()

    def _places(self, frame: Frame, body: int) -> list[Array]:
        """(3,) where the body's middle may be: by its colours, nearest to its size first."""
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
        for row, column in _blobs(likely):
            u, v = (column + 0.5) * _GRID_PX, (row + 0.5) * _GRID_PX
            z = self._depth_at(depth, frame.depth, u, v)
            if z > 0:
                ray = np.array([(u - color.cx) / color.fx, (v - color.cy) / color.fy, 1.0])
                places.append(ray * (z + 0.3 * self._radii[body]))
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


def _blobs(likely: npt.NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Middles (row, column) of the largest connected regions."""
    n, _, stats, centroids = cv2.connectedComponentsWithStats(likely.astype(np.uint8))
    sizes = stats[1:n, cv2.CC_STAT_AREA]
    order = np.argsort(-sizes)[:_BLOBS_MAX]
    return [
        (float(centroids[1 + i][1]), float(centroids[1 + i][0]))
        for i in order
        if sizes[i] >= _LEAST_CELLS
    ]
