"""The relative poses of all pairs of parts over time: their running mean, and how long it rests.

All pairs are held in arrays, so that eight parts cost no more than a few calls of NumPy a frame.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from snapfit.models.joint import angles
from snapfit.models.pose import Array, Pose
from snapfit.tracking.assembly.parameters import AssemblyParameters

Counts = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]

_LONGEST_MEAN = 30


class Relations:
    """Relative poses `a_from_b` of all pairs of parts.

    Attributes:
        first, second: (P,) numbers of the parts a and b of each pair.
        is_seen: (P,) whether both have a pose in this frame.
        mean: (P, 4, 4) running mean of `a_from_b`; its rotation is orthonormal but for noise.
        rest: (P, 4, 4) mean since the pair came to rest.
        still_frames: (P,) frames since then.
        is_sure: (P,) whether the poses of both are beyond doubt in this frame.
        sure_frames: (P,) in how many of `still_frames` they were.
        has_moved: (P,) whether the pair has been moved since it was first seen.
        start: (P, 4, 4) where it was then.
        part_moved: (N,) whether each part itself has been moved since it was first seen, not only
            another one beside it.
    """

    def __init__(self, parts: Sequence[str], parameters: AssemblyParameters) -> None:
        self._numbers = {name: i for i, name in enumerate(parts)}
        self._names = np.array(parts)
        self._parameters = parameters
        self.first, self.second = np.triu_indices(len(parts), k=1)
        n_pairs = len(self.first)
        self._pairs = {
            (int(a), int(b)): i
            for i, (a, b) in enumerate(zip(self.first, self.second, strict=True))
        }
        self._poses = np.tile(np.eye(4), (len(parts), 1, 1))
        self._first_poses = np.tile(np.eye(4), (len(parts), 1, 1))
        self._is_known: Flags = np.zeros(len(parts), dtype=np.bool_)
        self.part_moved: Flags = np.zeros(len(parts), dtype=np.bool_)
        self.is_seen: Flags = np.zeros(n_pairs, dtype=np.bool_)
        self.is_sure: Flags = np.zeros(n_pairs, dtype=np.bool_)
        self.mean = np.zeros((n_pairs, 4, 4))
        self.rest = np.zeros((n_pairs, 4, 4))
        self.start = np.zeros((n_pairs, 4, 4))
        self.still_frames: Counts = np.zeros(n_pairs, dtype=np.int64)
        self.sure_frames: Counts = np.zeros(n_pairs, dtype=np.int64)
        self.has_moved: Flags = np.zeros(n_pairs, dtype=np.bool_)
        self._was_seen: Flags = np.zeros(n_pairs, dtype=np.bool_)
        self._is_begun: Flags = np.ones(n_pairs, dtype=np.bool_)

    def update(
        self, camera_from_body: Mapping[str, Pose], sure: Collection[str] | None = None
    ) -> None:
        """Takes in the poses of a frame.

        Args:
            camera_from_body: by part; parts that are missing have none.
            sure: parts whose pose is beyond doubt; None is all that have one.
        """
        here = np.zeros(len(self._poses), dtype=np.bool_)
        for name, pose in camera_from_body.items():
            number = self._numbers[name]
            self._poses[number] = pose.matrix
            here[number] = True
        self._find_moved(here)
        self.is_seen = here[self.first] & here[self.second]
        certain = here if sure is None else here & np.isin(self._names, list(sure))
        self.is_sure = certain[self.first] & certain[self.second]
        if not self.is_seen.any():
            return
        measured = self._relative()
        self._smooth(measured)
        self._find_rest()

    def begin_anew(self, parts: Collection[str]) -> None:
        """Begin the means of parts anew, that are told from now on by another symmetric pose."""
        numbers = [self._numbers[name] for name in parts if name in self._numbers]
        self._is_begun &= ~(np.isin(self.first, numbers) | np.isin(self.second, numbers))

    def pair(self, part_a: str, part_b: str) -> tuple[int, bool]:
        """Number of a pair, and whether it holds b_from_a in place of a_from_b."""
        a, b = self._numbers[part_a], self._numbers[part_b]
        return (self._pairs[(a, b)], False) if a < b else (self._pairs[(b, a)], True)

    def mean_of(self, parent: str, child: str) -> Array:
        """(4, 4) running mean of `parent_from_child`."""
        index, is_swapped = self.pair(parent, child)
        return inverted(self.mean[index]) if is_swapped else self.mean[index]

    def still_of(self, part_a: str, part_b: str) -> int:
        """For how many frames two parts have been at rest against each other."""
        return int(self.still_frames[self.pair(part_a, part_b)[0]])

    def is_seen_of(self, part_a: str, part_b: str) -> bool:
        """Whether two parts both have a pose in this frame."""
        return bool(self.is_seen[self.pair(part_a, part_b)[0]])

    def is_known_of(self, part_a: str, part_b: str) -> bool:
        """Whether the relative pose of two parts is beyond doubt in this frame."""
        return bool(self.is_sure[self.pair(part_a, part_b)[0]])

    def _relative(self) -> Array:
        a, b = self._poses[self.first], self._poses[self.second]
        a_from_camera = np.swapaxes(a[:, :3, :3], 1, 2)
        relative = np.tile(np.eye(4), (len(a), 1, 1))
        relative[:, :3, :3] = a_from_camera @ b[:, :3, :3]
        apart = (b[:, :3, 3] - a[:, :3, 3])[..., None]
        relative[:, :3, 3] = (a_from_camera @ apart)[..., 0]
        return relative

    def _find_moved(self, here: Flags) -> None:
        """Which parts have left the place in which they were first seen; the camera stands."""
        new = here & ~self._is_known
        self._first_poses[new] = self._poses[new]
        self._is_known |= here
        if not self.part_moved.all():
            p = self._parameters
            way_m, turn_rad = distances(self._first_poses, self._poses)
            self.part_moved |= here & ((way_m > p.moved_m) | (turn_rad > p.moved_rad))

    def has_been_moved(self, part: str) -> bool:
        """Whether a part itself has been moved since it was first seen."""
        return bool(self.part_moved[self._numbers[part]])

    def _smooth(self, measured: Array) -> None:
        p, seen = self._parameters, self.is_seen
        way_m, turn_rad = distances(self.mean, measured)
        jumped = (way_m > p.jump_m) | (turn_rad > p.jump_rad)
        anew = seen & (~self._was_seen | ~self._is_begun | jumped)
        self.mean[seen] += p.smoothing * (measured[seen] - self.mean[seen])
        if anew.any():
            self.mean[anew] = self.rest[anew] = measured[anew]
            self.still_frames[anew] = self.sure_frames[anew] = 0
            first = anew & ~self._was_seen
            self.start[first] = measured[first]
            self._was_seen |= seen
            self._is_begun |= anew

    def _find_rest(self) -> None:
        p, seen = self._parameters, self.is_seen
        way_m, turn_rad = distances(self.rest, self.mean)
        moved = seen & ((way_m > p.still_m) | (turn_rad > p.still_rad))
        rests = seen & ~moved
        self.rest[moved] = self.mean[moved]
        self.still_frames[moved] = self.sure_frames[moved] = 0
        self.still_frames[rests] += 1
        self.sure_frames[rests & self.is_sure] += 1
        share = 1 / np.minimum(self.still_frames[rests] + 1, _LONGEST_MEAN)
        self.rest[rests] += share[:, None, None] * (self.mean[rests] - self.rest[rests])
        if not self.has_moved.all():
            way_m, turn_rad = distances(self.start, self.mean)
            self.has_moved |= seen & ((way_m > p.moved_m) | (turn_rad > p.moved_rad))


def distances(a: Array, b: Array) -> tuple[Array, Array]:
    """Translations (K,), m, and angles (K,), rad, between poses (K, 4, 4)."""
    apart = a[:, :3, 3] - b[:, :3, 3]
    way_m: Array = np.sqrt((apart * apart).sum(axis=1))
    return way_m, angles(np.swapaxes(a[:, :3, :3], 1, 2) @ b[:, :3, :3])


def inverted(pose: Array) -> Array:
    """(4, 4) inverse of a pose."""
    result = np.eye(4)
    result[:3, :3] = pose[:3, :3].T
    result[:3, 3] = -result[:3, :3] @ pose[:3, 3]
    return result
