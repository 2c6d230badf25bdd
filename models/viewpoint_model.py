"""The sparse viewpoint model of a body: contour and surface points for views from all around.

Source: Stoiber et al., "SRT3D" (IJCV 2022), and "Iterative Corresponding Geometry"
(CVPR 2022).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

N_POINTS = 300
OCCLUSION_RADIUS_M = 0.010
NORMAL_UNIT = 1 / 32767
SATURATED = 32767


@dataclass(frozen=True, eq=False)
class ViewpointModel:
    """What a body looks like from each of some viewpoints; arrays are read-only, body frame.

    Points of a view stand in an order whose first k are spread evenly, for every k. A view with
    fewer distinct points repeats some; one without a contour is all zero and has length zero.

    Attributes:
        center_m: (3,) float64, centre of the sphere of viewpoints.
        radius_m: distance of the viewpoints from the centre.
        directions: (n_views, 3) float32, unit, from the centre to the viewpoint.
        neighbours: (n_views, 6) int16, adjacent views; padded with the view itself.
        unit_m: metres of one count in the int16 positions and distances.
        contour: (n_views, 300, 9) int16: position xyz (unit_m); normal xyz (1/32767), in the
            image plane of the view, pointing out of the body; continuous foreground distance
            and background distance along the normal (unit_m, 32767 where it is longer); depth
            offset (unit_m): how much nearer the body itself comes within 10 mm beside the point.
        surface: (n_views, 300, 7) int16: position xyz (unit_m); normal xyz (1/32767), turned to
            the viewpoint; depth offset (unit_m) as above.
        contour_length_m: (n_views,) float32, length of the whole contour.
        surface_area_m2: (n_views,) float32, area of the silhouette in the plane of the centre.
    """

    center_m: npt.NDArray[np.float64]
    radius_m: float
    directions: npt.NDArray[np.float32]
    neighbours: npt.NDArray[np.int16]
    unit_m: float
    contour: npt.NDArray[np.int16]
    surface: npt.NDArray[np.int16]
    contour_length_m: npt.NDArray[np.float32]
    surface_area_m2: npt.NDArray[np.float32]

    @property
    def n_views(self) -> int:
        """The number of viewpoints."""
        return len(self.directions)
