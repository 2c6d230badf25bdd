"""What the page draws over the picture, beside what it should draw."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import numpy.typing as npt
from patience import within

from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.server.conventions import AXES, Convention

if TYPE_CHECKING:
    from playwright.sync_api import Page

Mask = npt.NDArray[np.bool_]

# The page tells which moment it has just drawn. Only drawings of which it had a snapshot of that
# very moment count: others are between two snapshots, and a busy browser misses many.
_COLLECT = """
async ([count, apartUs, limitMs]) => {
  const canvas = document.getElementById("overlay");
  const shots = [];
  let last = 0;
  let drawings = 0;
  await new Promise((resolve, reject) => {
    const late = () => `${shots.length} of ${count} in ${drawings} drawings, ${limitMs} ms`;
    setTimeout(() => reject(new Error(late())), limitMs);
    canvas.addEventListener("drawn", ({ detail }) => {
      drawings += 1;
      const snapshot = window.told.get(detail.atUs);
      if (!snapshot || shots.length === count || detail.atUs < last + apartUs) return;
      last = detail.atUs;
      shots.push({ snapshot, pictureAtUs: detail.pictureAtUs, png: canvas.toDataURL() });
      if (shots.length === count) resolve();
    });
  });
  return shots;
}
"""
_LIMIT_S = 60


@dataclass(frozen=True)
class Shot:
    """One drawing.

    Attributes:
        snapshot: of the moment that was drawn, in the camera's frame, the page's own axes.
        picture_at_us: exposure of the picture below.
        drawn: (H, W) bool, where anything is drawn.
    """

    snapshot: dict[str, Any]
    picture_at_us: int
    drawn: Mask

    def expected(self, camera: PinholeCamera, meshes: Mapping[str, Mesh]) -> Mask:
        """Where parts are seen by the camera, drawn by the rasteriser, as `drawn`."""
        factor = self.drawn.shape[1] / camera.width
        axes = AXES[Convention(self.snapshot["convention"])].inverse
        poses = {
            part["part"]: Pose.from_quaternion(
                axes.quaternion(part["orientation"]), axes.vector(part["position"])
            )
            for part in self.snapshot["parts"]
            if part["position"] is not None
        }
        bodies = [(meshes[name], pose) for name, pose in poses.items()]
        seen = render(camera.scaled(factor), bodies).part_id > 0
        return seen[: self.drawn.shape[0], : self.drawn.shape[1]]


def collect(page: Page, count: int, apart_us: int = 0) -> list[Shot]:
    """Some drawings of moments that the page had snapshots of, at least so far apart."""
    shots = page.evaluate(_COLLECT, [count, apart_us, within(_LIMIT_S) * 1000])
    return [Shot(it["snapshot"], it["pictureAtUs"], _alpha(it["png"]) > 0) for it in shots]


def outside(a: Mask, b: Mask, reach_px: int) -> float:
    """Share of a mask that is farther than so many pixels from another one."""
    kernel = np.ones((2 * reach_px + 1, 2 * reach_px + 1), dtype=np.uint8)
    near = cv2.dilate(b.astype(np.uint8), kernel) > 0
    return float((a & ~near).sum() / max(a.sum(), 1))


def best_shift(drawn: Mask, expected: Mask, most_px: int = 3) -> tuple[int, int]:
    """By how much x, y a mask has to be moved to agree best with what is drawn, whole pixels.

    Unlike a centroid it is not drawn to small parts, which the lines of their edges widen most.
    """
    wide = cv2.dilate(expected.astype(np.uint8), np.ones((3, 3), dtype=np.uint8)) > 0
    shifts = [(x, y) for x in range(-most_px, most_px + 1) for y in range(-most_px, most_px + 1)]
    return min(shifts, key=lambda by: int((np.roll(wide, by[::-1], (0, 1)) ^ drawn).sum()))


def centroid(mask: Mask) -> npt.NDArray[np.float64]:
    """(2,) x, y of the middle of a mask, px."""
    rows, columns = np.nonzero(mask)
    return np.array([columns.mean(), rows.mean()])


def _alpha(address: str) -> npt.NDArray[np.uint8]:
    png = np.frombuffer(base64.b64decode(address.partition(",")[2]), dtype=np.uint8)
    image = cv2.imdecode(png, cv2.IMREAD_UNCHANGED)
    assert image is not None
    alpha: npt.NDArray[np.uint8] = image[..., 3]
    return alpha
