"""The published GBOT dataset: BOP scenes by asset and condition, objects named by part.

Layout (records 10712703 and others on Zenodo; see the paper's repository, roth-hex-lab/gbot):
`ASSET/test/CONDITION/` holds `rgb/`, `depth/`, `scene_gt.json` and `scene_camera.json`, in
millimetres; an `obj_id` is a part's name. The camera of image 0 holds for all. Meshes are
`ASSET/models/PART.ply`, with `models_info.json` beside them.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pydantic import Field, TypeAdapter

from snapfit.models.asset import PALETTE_RGB, Part
from snapfit.models.bop import (
    CAMERA_NAME,
    MODELS_INFO_NAME,
    TRUTH_NAME,
    VISIBILITY_NAME,
    BopPose,
    BopVisibility,
    find_images,
    instance_pose,
    read_json,
    shared_camera,
    symmetry_from_info,
)
from snapfit.models.errors import SequenceError
from snapfit.models.mesh import load_mesh
from snapfit.models.pose import Pose
from snapfit.models.recording import FrameFiles, GroundTruth, Recording
from snapfit.models.symmetry import NO_SYMMETRY, Symmetry

PAPER_CONDITIONS = ("normal", "dynamic", "hand", "blur")

# The parts that the paper evaluates, and whether it calls them symmetric.
GBOT_ASSETS = MappingProxyType(
    {
        "GearedCaliper": {
            "Caliper_Fix": False,
            "Caliper_Move_Bottom": False,
            "Caliper_Move_Top_Vernier": False,
        },
        "HobbyCornerClamp": {
            "Corner_Clamp_Base": False,
            "Corner_Clamp_Bolt": True,
            "Corner_Clamp_Jaw": False,
        },
        "NanoViseV2": {
            "NanoViseV2_CLAMP_BALLJOINT": True,
            "NanoViseV2_CLAMP_BASE": False,
            "NanoViseV2_CLAMP_HEADPLATE": True,
            "NanoViseV2_CLAMP_NUT": True,
            "NanoViseV2_CLAMP_SCREW": True,
            "NanoViseV2_VISE_BASE": False,
            "NanoViseV2_VISE_SCREW": True,
            "NanoViseV2_VISE_SLIDER": False,
        },
        "Hand_ScrewClamp": {
            "HS_Jaw1": False,
            "HS_Jaw2": False,
            "HS_Knob1": True,
            "HS_Knob2": True,
            "HS_Pad": False,
            "HS_Thread1": True,
            "HS_Thread2": True,
        },
        "Liftpod": {
            "Liftpod_armfirst": True,
            "Liftpod_armlast": True,
            "Liftpod_bar": True,
            "Liftpod_baseplate": True,
            "Liftpod_clampframe": False,
            "Liftpod_clampslider": False,
            "Liftpod_sleeve": True,
        },
    }
)

SYMMETRIC_SOMEHOW = Symmetry((Pose.identity(),))
"""Of a part that the paper calls symmetric where the dataset does not say how: it is judged by
ADD-S; MSSD and MSPD, which need the motions, judge it as if it had no symmetry."""

_FRAME_RATE_HZ = 30.0
_MM = 0.001


class GbotTruth(BopPose):
    """An instance's entry of `scene_gt.json`."""

    part: str = Field(alias="obj_id", min_length=1)


def is_gbot_scene(scene: Path) -> bool:
    """Whether a folder is `ASSET/test/CONDITION` with the published name of an asset."""
    return scene.parent.parent.name in GBOT_ASSETS and (scene / CAMERA_NAME).is_file()


def load_gbot_scene(scene: Path) -> Recording:
    """Reads one scene; decodes its first image alone, for the size.

    Args:
        scene: `ASSET/test/CONDITION` with the published name of an asset.

    Raises:
        SequenceError: the asset is unknown, or a file or key is missing or wrong.
        MeshError: a mesh is refused.
    """
    scene = Path(scene)
    folder = scene.parent.parent
    if folder.name not in GBOT_ASSETS:
        known = ", ".join(GBOT_ASSETS)
        raise SequenceError(scene, f"{folder.name!r} is no asset of the GBOT dataset: {known}")
    frames = find_images(scene)
    parts = _parts(folder)
    truth = {each.frame: each for each in _truth(scene, frames, parts)}
    if frames[0].name not in truth:
        raise SequenceError(
            scene / TRUTH_NAME, f"nothing is said of the first image {frames[0].name}"
        )
    return Recording(
        name=f"{folder.name}-{scene.name}",
        directory=scene,
        camera=shared_camera(scene, frames[0]),
        frame_rate_hz=_FRAME_RATE_HZ,
        frames=frames,
        parts=parts,
        initial_poses=truth[frames[0].name].camera_from_body,
        truth=truth,
    )


def _parts(folder: Path) -> tuple[Part, ...]:
    models = folder / "models"
    if not models.is_dir():
        raise SequenceError(folder, "no folder `models` with the parts' meshes PART.ply (mm)")
    info: dict[str, dict[str, Any]] = {}
    path = models / MODELS_INFO_NAME
    if path.is_file():
        info = read_json(path, TypeAdapter(dict[str, dict[str, Any]]))
    parts = []
    for i, (name, is_symmetric) in enumerate(GBOT_ASSETS[folder.name].items()):
        mesh = load_mesh(models / f"{name}.ply", unit_m=_MM, require_closed=False)
        symmetry = symmetry_from_info(path, name, info.get(name, {}))
        if not is_symmetric:
            symmetry = NO_SYMMETRY
        elif symmetry.is_none:
            symmetry = SYMMETRIC_SOMEHOW
        parts.append(Part(name, mesh, PALETTE_RGB[i % len(PALETTE_RGB)], i, symmetry))
    return tuple(parts)


def _truth(
    scene: Path, frames: tuple[FrameFiles, ...], parts: tuple[Part, ...]
) -> Iterator[GroundTruth]:
    path = scene / TRUTH_NAME
    entries = read_json(path, TypeAdapter(dict[int, list[GbotTruth]]))
    seen: dict[int, list[BopVisibility]] = {}
    if (scene / VISIBILITY_NAME).is_file():
        adapter = TypeAdapter(dict[int, list[BopVisibility]])
        seen = read_json(scene / VISIBILITY_NAME, adapter)
    names = {part.name for part in parts}
    for frame in frames:
        image = int(frame.name)
        if image not in entries:
            continue
        kept = [(i, each) for i, each in enumerate(entries[image]) if each.part in names]
        shares = seen.get(image, [])
        yield GroundTruth(
            frame=frame.name,
            camera_from_body={e.part: instance_pose(path, image, e.part, e) for _, e in kept},
            visibility={e.part: shares[i].visib_fract for i, e in kept if i < len(shares)},
        )
