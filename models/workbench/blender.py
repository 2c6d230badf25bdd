"""Blender as a Python module, `bpy`: its import, and meshes, surfaces, camera in its terms.

Blender's world is ours: metres, z up. Its camera looks along its own -z with y up. Its colours are
linear, red first.
"""

from __future__ import annotations

import contextlib
import math
import os
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

import numpy as np

from snapfit.models.camera import PinholeCamera
from snapfit.models.errors import WorkbenchError
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.workbench.scene import (
    FLOOR_Z_M,
    TEXELS_PER_M,
    TOP_X_M,
    TOP_Y_M,
    Lamp,
    Scene,
    linear,
)

_SENSOR_MM = 36.0
_SHARP_DEG = 32.0
_METAL_GLOSS = 0.7
_FLOOR_RGB = (146, 142, 138)
_FLOOR_M = 6.0


def check_bpy() -> None:
    """Sees to it that Blender is there, without loading it.

    Raises:
        WorkbenchError: it is not installed.
    """
    if sys.modules.get("bpy") is None and find_spec("bpy") is None:
        raise WorkbenchError(
            "the renderer cycles needs Blender as a Python module, which is not installed: "
            "pip install 'snapfit[blender]' (it exists for Python 3.11), or use the own renderer"
        )


def load_bpy() -> Any:
    """The module `bpy`, with an empty scene in it.

    Raises:
        WorkbenchError: it is not installed, or a library that it needs is missing.
    """
    check_bpy()
    try:
        with quiet():
            import bpy
    except ImportError as error:
        problem = f"Blender's Python module cannot be loaded: {error}"
        raise WorkbenchError(f"{problem}; install that library, or use the own renderer") from error
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Keeps what Blender's own code prints off the terminal."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(number) for number in (1, 2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for number in (1, 2):
            os.dup2(nowhere, number)
        yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for number, own in zip((1, 2), kept, strict=True):
            os.dup2(own, number)
            os.close(own)
        os.close(nowhere)


def mesh_data(bpy: Any, mesh: Mesh) -> Any:
    """A mesh whose faces shade smoothly but across sharp edges."""
    data = bpy.data.meshes.new("mesh")
    data.from_pydata(mesh.vertices.tolist(), [], mesh.faces.tolist())
    data.shade_smooth()
    data.set_sharp_from_angle(angle=math.radians(_SHARP_DEG))
    return data


def place(thing: Any, world_from_thing: Pose) -> None:
    """Puts an object where a pose says."""
    thing.rotation_mode = "QUATERNION"
    x, y, z, w = (float(value) for value in world_from_thing.quaternion)
    thing.rotation_quaternion = (w, x, y, z)
    thing.location = tuple(float(value) for value in world_from_thing.translation)


def surface(bpy: Any, color_rgb: tuple[int, int, int], gloss: float) -> Any:
    """Plain plastic or, where the highlight is strong, metal; sRGB, 0 to 255."""
    material = bpy.data.materials.new("surface")
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    red, green, blue = (float(value) for value in linear(np.array(color_rgb, dtype=np.uint8)))
    shader.inputs["Base Color"].default_value = (red, green, blue, 1.0)
    shader.inputs["Roughness"].default_value = max(0.28, 0.72 * math.exp(-3.2 * gloss))
    shader.inputs["Metallic"].default_value = 1.0 if gloss >= _METAL_GLOSS else 0.0
    shader.inputs["Specular IOR Level"].default_value = 0.5 if gloss > 0 else 0.2
    return material


def add_ground(bpy: Any, scene: Scene) -> None:
    """The bench's top with its texture, and the floor."""
    rows, columns = scene.ground.shape[:2]
    image = bpy.data.images.new("ground", columns, rows, alpha=False)
    pixels = np.ones((rows, columns, 4), dtype=np.float32)
    # Blender's pictures begin with the lowest row, red first.
    pixels[..., :3] = scene.ground[::-1, :, ::-1] / np.float32(255)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    material = surface(bpy, (128, 128, 128), 0.05)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = image
    links.new(texture.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    # Texels' centres, not the picture's border, stand at whole steps from the corner.
    left, top = TOP_X_M[0] - 0.5 / TEXELS_PER_M, TOP_Y_M[1] + 0.5 / TEXELS_PER_M
    right, bottom = left + columns / TEXELS_PER_M, top - rows / TEXELS_PER_M
    _add_plane(bpy, (left, bottom, right, top), 0.0, material)
    floor = surface(bpy, _FLOOR_RGB, 0.0)
    _add_plane(bpy, (-_FLOOR_M, -_FLOOR_M, _FLOOR_M, _FLOOR_M), FLOOR_Z_M, floor)


def _add_plane(
    bpy: Any, corners_m: tuple[float, float, float, float], z_m: float, material: Any
) -> None:
    left, bottom, right, top = corners_m
    data = bpy.data.meshes.new("plane")
    corners = [(left, bottom, z_m), (right, bottom, z_m), (right, top, z_m), (left, top, z_m)]
    data.from_pydata(corners, [], [(0, 1, 2, 3)])
    across = data.uv_layers.new().data
    for loop, place_uv in zip(across, ((0, 0), (1, 0), (1, 1), (0, 1)), strict=True):
        loop.uv = place_uv
    data.materials.append(material)
    bpy.context.collection.objects.link(bpy.data.objects.new("plane", data))


def set_camera(bpy: Any, camera: PinholeCamera, camera_from_world: Pose) -> None:
    """The camera of the scene: pixel centres at integers, as everywhere in snapfit."""
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit, lens.sensor_width = "HORIZONTAL", _SENSOR_MM
    lens.lens = camera.fx * _SENSOR_MM / camera.width
    # The picture goes from -0.5 to its size less 0.5; shifts are shares of its width.
    lens.shift_x = ((camera.width - 1) / 2 - camera.cx) / camera.width
    aspect = camera.fx / camera.fy
    lens.shift_y = (camera.cy - (camera.height - 1) / 2) * aspect / camera.width
    lens.clip_start, lens.clip_end = 0.01, 100.0
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = camera.width, camera.height
    render.resolution_percentage = 100
    # Blender takes no aspect below 1.
    render.pixel_aspect_x, render.pixel_aspect_y = max(1.0, 1 / aspect), max(1.0, aspect)
    thing = bpy.data.objects.new("camera", lens)
    half_turn = Pose.from_rotation_translation(np.diag([1.0, -1.0, -1.0]), (0, 0, 0))
    place(thing, camera_from_world.inverse() @ half_turn)
    bpy.context.collection.objects.link(thing)
    bpy.context.scene.camera = thing


def lamp_object(bpy: Any, lamp: Lamp) -> Any:
    """A ball of light. From so many watts a white matt surface 1 m away gets `intensity`."""
    light = bpy.data.lights.new("lamp", type="POINT")
    brightest = max(*lamp.intensity, 1e-9)
    light.energy = 4 * math.pi**2 * brightest
    blue, green, red = (value / brightest for value in lamp.intensity)
    light.color = (red, green, blue)
    light.shadow_soft_size = lamp.diameter_m / 2
    thing = bpy.data.objects.new("lamp", light)
    thing.location = lamp.position_m
    return thing
