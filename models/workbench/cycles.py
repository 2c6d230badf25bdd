"""Photo-real pictures of the simulated bench: Blender's path tracer, Cycles, draws the same scenes.

Poses, camera, lamps, meshes, colours and ground are those of the own renderer, and so is what is
true in a frame: masks, depth and visibility come from the rasteriser.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Asset
from snapfit.models.errors import WorkbenchError
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench import stage_kernels
from snapfit.models.workbench.blender import (
    add_ground,
    lamp_object,
    load_bpy,
    mesh_data,
    place,
    quiet,
    set_camera,
    surface,
)
from snapfit.models.workbench.film import Film
from snapfit.models.workbench.hand import Body
from snapfit.models.workbench.light import DIM_AMBIENT, moving_lamp
from snapfit.models.workbench.scene import Lamp, Scene
from snapfit.models.workbench.shading import PART_GLOSS, encoding
from snapfit.models.workbench.split import EFFECTS, Condition
from snapfit.models.workbench.stage import Picture

Singles = npt.NDArray[np.float32]

SAMPLES = 48
_BOUNCES = 6


class Cycles:
    """Draws one scene; the last one made is the one that Blender holds.

    Raises:
        WorkbenchError: Blender is not installed.
    """

    def __init__(self, scene: Scene) -> None:
        self._bpy = bpy = load_bpy()
        self._meshes: dict[int, tuple[Mesh, Any]] = {}
        self._surfaces: dict[tuple[tuple[int, int, int], float], Any] = {}
        self._shown: list[Any] = []
        self._set_up()
        set_camera(bpy, scene.camera, scene.camera_from_world)
        add_ground(bpy, scene)
        for item in scene.items:
            body = Body(item.mesh, item.world_from_body, item.color_rgb, item.gloss)
            bpy.context.collection.objects.link(self._object(body))

    def picture(
        self,
        bodies: Sequence[Body],
        lamps: Sequence[Lamp],
        ambient: Array,
        *,
        samples: int = SAMPLES,
        seed: int = 0,
    ) -> Singles:
        """(H, W, 3) linear light, blue first.

        Args:
            bodies: parts and hand, beside the things on the bench.
            lamps: that throw shadows.
            ambient: (2, 3) light from above and from below, linear, blue first.
            samples: paths of light a pixel; Blender takes most of the noise that is left away.
            seed: of the paths.
        """
        bpy = self._bpy
        for thing in self._shown:
            bpy.data.objects.remove(thing)
        self._shown = [self._object(body) for body in bodies]
        for i, thing in enumerate(self._shown):
            thing.pass_index = i + 1
        self._shown += [lamp_object(bpy, lamp) for lamp in lamps]
        for thing in self._shown:
            bpy.context.collection.objects.link(thing)
        for background, light in zip(self._sky, ambient, strict=True):
            blue, green, red = (float(value) for value in light)
            background.inputs["Color"].default_value = (red, green, blue, 1.0)
        bpy.context.scene.cycles.samples, bpy.context.scene.cycles.seed = samples, seed
        return self.rendered()

    def rendered(self) -> Singles:
        """(H, W, 3) linear light, blue first, of what Blender holds now."""
        with tempfile.TemporaryDirectory(prefix="snapfit-cycles-") as folder:
            path = Path(folder) / "frame.exr"
            self._bpy.context.scene.render.filepath = str(path)
            with quiet():
                self._bpy.ops.render.render(write_still=True)
            image = self._bpy.data.images.load(str(path))
            width, height = image.size
            pixels = np.empty(width * height * 4, dtype=np.float32)
            image.pixels.foreach_get(pixels)
            self._bpy.data.images.remove(image)
        # Blender begins with the lowest row, red first.
        return np.ascontiguousarray(pixels.reshape(height, width, 4)[::-1, :, 2::-1])

    def _object(self, body: Body) -> Any:
        key = id(body.mesh)
        if key not in self._meshes:
            self._meshes[key] = body.mesh, mesh_data(self._bpy, body.mesh)
        look = (body.color_rgb, body.gloss)
        if look not in self._surfaces:
            self._surfaces[look] = surface(self._bpy, *look)
        data = self._meshes[key][1]
        thing = self._bpy.data.objects.new("body", data)
        # The material is the object's own: bodies of several colours share a mesh.
        if not data.materials:
            data.materials.append(None)
        thing.material_slots[0].link = "OBJECT"
        thing.material_slots[0].material = self._surfaces[look]
        place(thing, body.world_from_body)
        return thing

    def _set_up(self) -> None:
        scene = self._bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.cycles.max_bounces = _BOUNCES
        scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = False
        scene.cycles.use_denoising = True
        # What stays is not built anew for each frame.
        scene.render.use_persistent_data = True
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        scene.world = self._bpy.data.worlds.new("sky")
        scene.world.use_nodes = True
        nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
        nodes.clear()
        below, above = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeBackground")
        direction = nodes.new("ShaderNodeTexCoord").outputs["Generated"]
        split, is_up = nodes.new("ShaderNodeSeparateXYZ"), nodes.new("ShaderNodeMath")
        is_up.operation = "GREATER_THAN"
        is_up.inputs[1].default_value = 0.0
        mix, out = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeOutputWorld")
        links.new(direction, split.inputs[0])
        links.new(split.outputs["Z"], is_up.inputs[0])
        links.new(is_up.outputs[0], mix.inputs[0])
        links.new(below.outputs[0], mix.inputs[1])
        links.new(above.outputs[0], mix.inputs[2])
        links.new(mix.outputs[0], out.inputs["Surface"])
        self._sky = (above, below)


class CyclesFilm(Film):
    """The assembly of an asset, its colour pictures by Cycles.

    Raises:
        WorkbenchError: as `Film`, or Blender is not installed.
    """

    def __init__(
        self,
        asset: Asset,
        n_frames: int,
        seed: int,
        scale: float = 1.0,
        *,
        samples: int = SAMPLES,
    ) -> None:
        super().__init__(asset, n_frames, seed, scale)
        self._samples = samples
        self._cycles = Cycles(self.scene)

    def beside(self, camera_from_world: Pose) -> Film:
        """Blender holds one scene and one camera a process.

        Raises:
            WorkbenchError: always.
        """
        x, y, z = camera_from_world.inverse().translation
        raise WorkbenchError(
            f"no second camera at ({x:.2f}, {y:.2f}, {z:.2f}) m: Cycles has one camera; "
            "take a second one beside a `Film`"
        )

    def _picture(self, time_s: float, condition: Condition) -> Picture:
        """As by the own renderer, but for the colours."""
        camera = self.scene.camera
        lamps: Sequence[Lamp] = self.scene.lamps
        ambient = self.scene.ambient
        if EFFECTS[condition].moving_light:
            lamps, ambient = [moving_lamp(time_s, self._light_phase())], DIM_AMBIENT
        instants = self._instants(time_s, condition)
        samples = math.ceil(self._samples / len(instants))
        light = np.zeros((camera.height, camera.width, 3), dtype=np.float32)
        for i, (poses, hand) in enumerate(instants):
            parts = [
                Body(part.mesh, poses[part.name], part.color_rgb, PART_GLOSS)
                for part in self.asset.parts
            ]
            bodies = [*parts, *hand]
            seen = self._cycles.picture(bodies, lamps, ambient, samples=samples, seed=i)
            light += seen / len(instants)
        clean = super()._picture(time_s, condition)
        return replace(clean, color=stage_kernels.encoded(light, encoding()))
