"""What the kernels share: settings as named tuples, working arrays of all bodies side by side.

Shapes: B bodies, N lines or points of a body, V views. All lengths are metres, angles rad, image
places px; single precision is enough (a pixel of 1280 is resolved to 1e-4).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
I16 = npt.NDArray[np.int16]
I32 = npt.NDArray[np.int32]
I64 = npt.NDArray[np.int64]
U8 = npt.NDArray[np.uint8]
U16 = npt.NDArray[np.uint16]

FAST = {"contract", "reassoc", "nsz", "arcp"}
"""Fast mathematics that still knows NaN and infinity: a diverged step must be seen."""

CONTOUR_WIDTH = 9
SURFACE_WIDTH = 7
"""Values of a contour point and of a surface point in a viewpoint model."""
NORMAL_UNIT = np.float32(1.0 / 32767.0)


class Intrinsics(NamedTuple):
    """A pinhole camera, px."""

    fx: np.float32
    fy: np.float32
    cx: np.float32
    cy: np.float32
    width: int
    height: int


class Images(NamedTuple):
    """What is seen in one frame.

    Attributes:
        color: (H, W, 3) BGR.
        depth: (h, w) depth image, `Cameras.depth_unit` metres a count; 0 and 65535 are nothing.
        near_depth, near_id: the small rendering of all bodies at their predicted poses; depth in
            m, 0 is nothing; id is the body's index + 1.
        neighboured: (B,) 1 where another body's image may touch the body's.
        alike: (B, B) 1 where two bodies have the same colour.
        hiding: (B,) how much nearer than a body something measured must be to hide it, m.
    """

    color: U8
    depth: U16
    near_depth: F32
    near_id: U8
    neighboured: U8
    alike: U8
    hiding: F32


class Cameras(NamedTuple):
    """The two cameras.

    Attributes:
        color, depth: (6,) intrinsics, see `intrinsics`; parallel kernels take no nested tuples.
        depth_unit: metres a count of the depth image.
        color_from_depth, depth_from_color: (4, 4) between the cameras.
    """

    color: F32
    depth: F32
    depth_unit: np.float32
    color_from_depth: F32
    depth_from_color: F64


class Models(NamedTuple):
    """The sparse viewpoint models of all bodies; the geodesic grid is the same for each.

    Attributes:
        directions: (V, 3) unit, body frame, from the centre to the viewpoint.
        neighbours: (V, 6) adjacent views.
        contours: (B,) address of each body's (V, N, 9) int16, see `ViewpointModel.contour`.
        surfaces: (B,) address of each body's (V, N, 7) int16, see `ViewpointModel.surface`.
        n_rows: N.
        units: (B,) metres a count of the two.
        centers: (B, 3) centre of the viewpoints, body frame, m.
        line_counts, point_counts: (B, V) lines and points that a view gets.
    """

    directions: F32
    neighbours: I16
    contours: I64
    surfaces: I64
    n_rows: int
    units: F32
    centers: F32
    line_counts: I64
    point_counts: I64


class Bodies(NamedTuple):
    """The state of all bodies.

    Attributes:
        active: (B,) 1 where the body takes part.
        poses: (B, 4, 4) camera_from_body, colour camera.
        color_poses, depth_poses: (B, 4, 4) single precision, in the two cameras' frames.
        views: (B,) closest view.
        tables: (B, 4096) posterior of the foreground, by colour.
        depth_scales: (B,) factor on the depth modality's deviations: its noise, as seen lately.
        solved: (B,) 0 where a Newton step failed.
        gradients, hessians: (B, 6) and (B, 6, 6) of the last step, without regularisation.
    """

    active: U8
    poses: F64
    color_poses: F32
    depth_poses: F32
    views: I64
    tables: F32
    depth_scales: F32
    solved: U8
    gradients: F64
    hessians: F64


class Structures(NamedTuple):
    """How bodies are linked: trees of joints (Mb-ICG); a free body is a tree of one.

    Attributes:
        parents: (B,) index of the body that carries it, -1 for a root.
        order: (B,) bodies by structure, parents before their children.
        starts: (B + 1,) where each structure begins in `order`; B where there are no more.
        zeros: (B, 4, 4) parent_from_child with all coordinates zero.
        twists: (B, 2, 6) right perturbations of the child, its frame, of each coordinate.
        n_dof: (B,) coordinates of the joint to the parent, 0 to 2.
        q: (B, 2) the coordinates, rad or m.
        limits: (B, 2, 2) least and largest coordinate.
    """

    parents: I64
    order: I64
    starts: I64
    zeros: F64
    twists: F64
    n_dof: I64
    q: F64
    limits: F64


class RegionSettings(NamedTuple):
    """The region modality; arrays have an entry for each correspondence iteration."""

    scales: I64
    sigmas: F32
    step_foreground: F32
    min_continuous: np.float32
    min_variance: np.float32
    learning_rate: np.float32
    outlying: np.float32
    global_updates: int


class DepthSettings(NamedTuple):
    """The depth modality; arrays have an entry for each correspondence iteration."""

    considered: F32
    sigmas: F32
    strides: F32
    beside: np.float32
    beside_slope: np.float32


class OcclusionSettings(NamedTuple):
    """Measured and modelled occlusion; see `OcclusionParameters`."""

    measured: bool
    modelled: bool
    radius: np.float32
    modelled_threshold: np.float32
    image_scale: np.float32


class Lines(NamedTuple):
    """The correspondence lines of all bodies.

    Attributes:
        point: (B, N, 3) contour point, body frame.
        place: (B, N, 8) centre u, v; normal u, v; offset of the pixel grid along the normal, px;
            segments per px along the normal; continuous foreground and background distance, px.
        posterior: (B, N, 12) over the contour's offset, sums to one.
        moments: (B, N, 2) mean and variance of the posterior, segments.
        valid: (B, N) 1 where the line takes part.
    """

    point: F32
    place: F32
    posterior: F32
    moments: F32
    valid: U8


class Points(NamedTuple):
    """The surface points of all bodies.

    Attributes:
        point: (B, N, 3) body frame.
        normal: (B, N, 3) body frame.
        measured: (B, N, 3) closest measured point, colour camera frame.
        weight: (B, N) 1 / variance of the measured point, 1/m^2.
        valid: (B, N) 1 where the point takes part.
    """

    point: F32
    normal: F32
    measured: F32
    weight: F32
    valid: U8


CONSIDERED, OCCLUDED, VALID = 0, 1, 2
"""What became of lines and points: in the image; hidden; taking part."""
