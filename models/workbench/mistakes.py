"""Assemblies that go wrong: what is done so far is right, and then a part is put wrongly.

It comes to rest touching what is assembled: beside its place, the wrong way round, in the place of
another part, or before its turn.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from snapfit.models.asset import Asset
from snapfit.models.errors import WorkbenchError
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.models.workbench.choreography import Bodies, Choreographer, Pace
from snapfit.models.workbench.layout import laid_out, root_of
from snapfit.models.workbench.mistake import Mistake, MistakeKind
from snapfit.models.workbench.mistake_poses import Setting, WrongPose, WrongPoses
from snapfit.models.workbench.mounting import plan_mounts
from snapfit.models.workbench.scene import Scene
from snapfit.models.workbench.script import Script
from snapfit.models.workbench.sighting import sighting
from snapfit.models.workbench.split import FRAME_RATE_HZ

REST_FRAMES = 46
_MOUNT_FRAMES = 80
_LOOK = 0.25
# A part of which less is in view cannot be judged by anybody.
_LEAST_SEEN = 0.4
_SETTLED_S = 4 / FRAME_RATE_HZ


class MistakeMaker:
    """Makes mistakes in the assembly of one asset on one bench.

    Args:
        asset: with an assembly graph.
        scene: on which it lies.
        seed: of all choices.

    Raises:
        WorkbenchError: no assembly graph, or the parts do not fit on the bench.
    """

    def __init__(self, asset: Asset, scene: Scene, seed: int) -> None:
        self._asset, self._scene, self._seed = asset, scene, seed
        self._plan = plan_mounts(asset)
        self._bodies = Bodies.of({part.name: part.mesh for part in asset.parts})
        self._tracked = frozenset(part.name for part in asset.tracked_parts)
        initial = laid_out(asset, scene, self._plan, np.random.default_rng((seed, 0)))
        self._n_frames = _MOUNT_FRAMES * sum(len(mounts) for _, mounts in self._plan)
        player = self._choreographer(asset.states[0].name, initial)
        self._right = player.play(self._n_frames)

    def make(self, kind: MistakeKind) -> tuple[Script, Mistake]:
        """A script in which something goes wrong, and what.

        Args:
            kind: that is wanted; where no shape allows it, another kind is taken.

        Raises:
            WorkbenchError: nothing of this asset can be put wrongly in view of the camera.
        """
        kinds = list(MistakeKind)
        start = kinds.index(kind)
        for i, each in enumerate((*kinds[start:], *kinds[:start])):
            rng = np.random.default_rng((self._seed, 6, i))
            for setting in self._settings(rng):
                for wrong in WrongPoses(setting, self._bodies.clearance, rng).of(each):
                    seen = self._visibility(setting, wrong)
                    if seen >= _LEAST_SEEN:
                        return self._played(setting, wrong, seen)
        raise WorkbenchError(f"no part of {self._asset.name!r} can be put wrongly in view")

    def _settings(self, rng: np.random.Generator) -> Iterator[Setting]:
        """The bench before each step, in any order."""
        root = root_of([mount.link for _, mounts in self._plan for mount in mounts])
        links = {state.name: state.links for state in self._asset.states}
        for i in rng.permutation(len(self._plan)):
            step = self._plan[i][0]
            time_s = self._right.states[i][0]
            poses = self._right.poses_at(time_s + (_SETTLED_S if i else 0.0))
            later = [mount for _, mounts in self._plan[i + 1 :] for mount in mounts]
            state = step.from_state
            yield Setting(self._asset, state, links[state], poses, root, self._plan[i][1], later)

    def _visibility(self, setting: Setting, wrong: WrongPose) -> float:
        """Share of the part that the camera sees."""
        camera, view = self._scene.camera.scaled(_LOOK), self._scene.camera_from_world
        poses = {**setting.poses, wrong.part: wrong.goal}
        names = list(poses)
        meshes = {part.name: part.mesh for part in self._asset.parts}
        seen = render(camera, [(meshes[name], view @ poses[name]) for name in names])
        mask = seen.part_id == names.index(wrong.part) + 1
        nothing = np.zeros(mask.shape, dtype=np.uint16)
        pose = view @ wrong.goal
        return min(sighting(camera, meshes[wrong.part], pose, mask, nothing).visibility, 1.0)

    def _played(self, setting: Setting, wrong: WrongPose, seen: float) -> tuple[Script, Mistake]:
        player = self._choreographer(setting.state, setting.poses, setting)
        script = player.carry(wrong.part, wrong.goal, wrong.back_m, REST_FRAMES)
        mistake = Mistake(
            kind=wrong.kind,
            part=wrong.part,
            parent=wrong.parent,
            state=setting.state,
            rest_frame=round(script.moves[-1].end_s * FRAME_RATE_HZ),
            translation_m=round(min(wrong.translation_m, 9.0), 5),
            rotation_deg=round(float(np.degrees(min(wrong.rotation_rad, np.pi))), 2),
            visibility=round(seen, 3),
        )
        return script, mistake

    def _choreographer(
        self, state: str, poses: Mapping[str, Pose], setting: Setting | None = None
    ) -> Choreographer:
        links = () if setting is None else setting.links
        return Choreographer(
            state, self._tracked, self._bodies, poses, self._plan, Pace(), self._seed, links
        )


def n_frames_of(script: Script) -> int:
    """Frames from the first to the last."""
    return round(script.duration_s * FRAME_RATE_HZ) + 1
