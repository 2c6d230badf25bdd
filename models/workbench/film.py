"""Any frame of an asset's assembly under any condition; the same seed gives the same bytes."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Asset
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.workbench.assembly import timed_assembly
from snapfit.models.workbench.bench import sampled_scene
from snapfit.models.workbench.grasp import HandScript
from snapfit.models.workbench.hand import Body
from snapfit.models.workbench.scene import STANDARD_CAMERA
from snapfit.models.workbench.script import Script
from snapfit.models.workbench.sensor import Sensor
from snapfit.models.workbench.sighting import Sighting, sighting
from snapfit.models.workbench.speed import moving_part
from snapfit.models.workbench.split import EFFECTS, FRAME_RATE_HZ, Condition
from snapfit.models.workbench.stage import Backdrop, Picture, Stage

_INSTANTS = 5
_BACKDROPS = 3


@dataclass(frozen=True, eq=False)
class FilmFrame:
    """One frame as the camera delivers it, and what is true in it.

    Attributes:
        color: (H, W, 3) uint8, blue first.
        depth: (H, W) uint16, mm, 0 is none; aligned with colour.
        sightings: of each tracked part.
        state: the assembly state.
        in_hand: the part that moves, None while all rest.
    """

    color: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.uint16]
    sightings: Mapping[str, Sighting]
    state: str
    in_hand: str | None


class Film:
    """The assembly of an asset in front of a camera.

    Args:
        asset: whose parts are seen.
        n_frames: of the assembly.
        seed: of everything.
        scale: share of 1280x720.
        script: what happens on the bench of this seed; None is the assembly.

    Raises:
        WorkbenchError: as `timed_assembly`.
    """

    def __init__(
        self,
        asset: Asset,
        n_frames: int,
        seed: int,
        scale: float = 1.0,
        script: Script | None = None,
    ) -> None:
        scene = sampled_scene(seed, [part.color_rgb for part in asset.parts])
        if scale != 1.0:
            scene = scene.scaled(scale)
        self.asset, self.scene, self.n_frames, self._seed = asset, scene, n_frames, seed
        self.camera = RgbdCamera(scene.camera, scene.camera)
        self.script = script or timed_assembly(asset, scene, n_frames, seed)
        self._stage = Stage(scene, asset.parts)
        self._sensor = Sensor(scene.camera, np.random.default_rng((seed, 2)))
        eye = scene.camera_from_world.inverse().translation
        meshes = {part.name: part.mesh for part in asset.parts}
        tracked = {part.name for part in asset.tracked_parts}
        rng = np.random.default_rng((seed, 3))
        self._hand = HandScript(self.script, meshes, eye, rng, tracked)
        self._kept: dict[bytes, Backdrop] = {}
        self._noise_seed = (seed, 4)

    def beside(self, camera_from_world: Pose) -> Film:
        """The same film, its hand included, as another camera on the bench sees it.

        The hand comes before parts as the first camera sees them. Noise is another.
        """
        other = copy(self)
        other.scene = replace(self.scene, camera_from_world=camera_from_world)
        other._stage = Stage(other.scene, self.asset.parts)
        other._sensor = Sensor(other.scene.camera, np.random.default_rng((self._seed, 6)))
        other._kept = {}
        other._noise_seed = (self._seed, 7)
        return other

    @staticmethod
    def camera_of(scale: float) -> RgbdCamera:
        """The camera of every film in a size."""
        camera = STANDARD_CAMERA if scale == 1.0 else STANDARD_CAMERA.scaled(scale)
        return RgbdCamera(camera, camera)

    def frame(self, index: int, condition: Condition) -> FilmFrame:
        """Renders a frame; consecutive frames are quicker than frames out of order."""
        time_s = index / FRAME_RATE_HZ
        picture = self._picture(time_s, condition)
        order = list(Condition).index(condition)
        rng = np.random.default_rng((*self._noise_seed, order, index))
        poses = self.script.poses_at(time_s)
        depth = self._sensor.depth(picture.depth, rng)
        return FilmFrame(
            color=self._sensor.color(picture.color, rng),
            depth=depth,
            sightings=self._sightings(poses, picture, depth),
            state=self.script.state_at(time_s),
            in_hand=moving_part(self.script, index),
        )

    def _picture(self, time_s: float, condition: Condition) -> Picture:
        moving = self._moving_at(time_s)
        instants = [
            ({name: poses[name] for name in moving}, hand)
            for poses, hand in self._instants(time_s, condition)
        ]
        light = (time_s, self._light_phase()) if EFFECTS[condition].moving_light else None
        return self._stage.picture(self._backdrop(time_s, moving), instants, light)

    def _instants(
        self, time_s: float, condition: Condition
    ) -> list[tuple[dict[str, Pose], list[Body]]]:
        """`world_from_part` of all parts and the hand, at moments spread over the exposure."""
        effects = EFFECTS[condition]
        n = _INSTANTS if effects.exposure else 1
        shutter_s = effects.exposure / FRAME_RATE_HZ
        instants = []
        for i in range(n):
            at_s = float(np.clip(time_s + ((i + 0.5) / n - 0.5) * shutter_s, 0, None))
            hand = self._hand.bodies_at(at_s) if effects.hand else []
            instants.append((self.script.poses_at(at_s), hand))
        return instants

    def _light_phase(self) -> float:
        """Where the moving light starts, 0 to 1."""
        return float(np.random.default_rng((self._seed, 5)).random())

    def _moving_at(self, time_s: float) -> tuple[str, ...]:
        """Parts that move now or, at rest, those that moved last or will move first."""
        begun = [m for m in self.script.moves if m.start_s <= time_s + 0.5 / FRAME_RATE_HZ]
        move = begun[-1] if begun else self.script.moves[0]
        return (move.part, *sorted(move.carried))

    def _backdrop(self, time_s: float, moving: tuple[str, ...]) -> Backdrop:
        poses = self.script.poses_at(time_s)
        standing = {name: pose for name, pose in poses.items() if name not in moving}
        key = b"".join(name.encode() + pose.matrix.tobytes() for name, pose in standing.items())
        if key not in self._kept:
            if len(self._kept) >= _BACKDROPS:
                del self._kept[next(iter(self._kept))]
            self._kept[key] = self._stage.backdrop(standing)
        return self._kept[key]

    def _sightings(
        self, poses: Mapping[str, Pose], picture: Picture, depth: npt.NDArray[np.uint16]
    ) -> dict[str, Sighting]:
        view, camera = self.scene.camera_from_world, self.scene.camera
        found = {}
        for i, part in enumerate(self.asset.parts):
            if not part.tracked:
                continue
            pose = view @ poses[part.name]
            mask = picture.label == i + 1
            found[part.name] = sighting(camera, part.mesh, pose, mask, depth)
        return found
