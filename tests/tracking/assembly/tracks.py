"""Poses of parts over time, as the workbench has them, with a tracker's noise; nothing rendered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from unittest import mock

import numpy as np

from snapfit.models.asset import Asset, find_asset
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench import assembly
from snapfit.models.workbench.scene import standard_scene
from snapfit.tracking.assembly.estimate import AssemblyEstimate, PartObservation, Probe
from snapfit.tracking.assembly.judge import StateJudge
from snapfit.tracking.assembly.parameters import AssemblyParameters
from snapfit.tracking.result import Status

RATE_HZ = 30


@dataclass(frozen=True)
class Track:
    """A sequence: true poses and true state of every frame."""

    asset: Asset
    poses: Sequence[Mapping[str, Pose]]
    states: Sequence[str]

    @property
    def switches(self) -> list[int]:
        return [f for f in range(1, len(self.states)) if self.states[f] != self.states[f - 1]]


@dataclass(frozen=True)
class Noise:
    """Errors of a tracker: half of the variance is white, half wanders within half a second.

    Attributes:
        way_m: root mean square of the error's length.
        turn_rad: the same of its angle.
        hidden: (part, first frame, last frame) without a pose.
    """

    way_m: float
    turn_rad: float
    hidden: Sequence[tuple[str, int, int]] = field(default=())


def track_of(name: str, n_frames: int, seed: int) -> Track:
    asset = find_asset(name)
    # The pace need not be that of the benchmark to a percent.
    with mock.patch.object(assembly, "_CALIBRATIONS", 1):
        scene = standard_scene(np.random.default_rng((seed, 1)))
        script = assembly.timed_assembly(asset, scene, n_frames, seed)
    poses = [script.poses_at(f / RATE_HZ) for f in range(n_frames)]
    return Track(asset, poses, [script.state_at(f / RATE_HZ) for f in range(n_frames)])


def wandering(n_frames: int, noise: Noise, rng: np.random.Generator) -> Array:
    """(F, 6) errors of one part."""
    scale = np.repeat([noise.turn_rad, noise.way_m], 3) / np.sqrt(6)
    white = rng.standard_normal((n_frames, 6))
    slow = rng.standard_normal((n_frames, 6))
    keep = np.exp(-1 / 15)
    for f in range(1, n_frames):
        slow[f] = keep * slow[f - 1] + np.sqrt(1 - keep**2) * slow[f]
    errors: Array = (white + slow) * scale
    return errors


def observed(track: Track, noise: Noise, seed: int) -> list[list[PartObservation]]:
    """What a tracker would say, frame by frame."""
    rng = np.random.default_rng(seed)
    n_frames = len(track.poses)
    names = [part.name for part in track.asset.tracked_parts]
    errors = {name: wandering(n_frames, noise, rng) for name in names}
    variances = np.repeat([noise.turn_rad, noise.way_m], 3) ** 2 / 3
    frames = []
    for f in range(n_frames):
        observations = []
        for name in names:
            if any(part == name and a <= f <= b for part, a, b in noise.hidden):
                observations.append(PartObservation(name, Status.LOST, 0.0, None, visibility=0.0))
                continue
            pose = track.poses[f][name].perturbed(errors[name][f])
            observations.append(
                PartObservation(name, Status.TRACKED, 0.9, pose, np.diag(variances), 1.0, pose)
            )
        frames.append(observations)
    return frames


def judged(
    track: Track,
    noise: Noise,
    seed: int,
    parameters: AssemblyParameters | None = None,
    probe: Probe | None = None,
) -> list[AssemblyEstimate]:
    judge = StateJudge(track.asset, parameters or AssemblyParameters())
    frames = observed(track, noise, seed)
    return [judge.update(each, f, probe) for f, each in enumerate(frames)]
