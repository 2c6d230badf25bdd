"""What a tracking method is: an entry of the table of methods, and the tracker that it gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal, Protocol

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.following import GraphParameters
from snapfit.tracking.frame import Frame
from snapfit.tracking.parameters import TrackerParameters
from snapfit.tracking.result import TrackingResult

# Imported by their names when they are needed: trackers load no ONNX Runtime and no Open3D, and
# their finished runs stand when detection changes.
FRAME_BY_FRAME = "snapfit.tracking.detection.frame_by_frame"
REINITIALISED = "snapfit.tracking.finding.reinitialised"
NETWORK = "snapfit.tracking.detection.detector"
FINDERS = MappingProxyType(
    {
        "network": "snapfit.tracking.finding.guidance",
        "geometric": "snapfit.tracking.finding.geometric",
    }
)
"""By detector: the module of its finder."""


@dataclass(frozen=True)
class Latency:
    """How long a detector takes for a look.

    Attributes:
        look_s: whatever is looked for.
        part_s: for each part more.
    """

    look_s: float
    part_s: float

    def of_parts_s(self, n_parts: int) -> float:
        """How long it looks for so many parts, s."""
        return self.look_s + self.part_s * n_parts


LATENCIES: Mapping[str, Latency] = MappingProxyType(
    {"network": Latency(0.12, 0.095), "geometric": Latency(0.1, 0.12)}
)
"""By detector, on one core (docs/finding.md). An answer comes as many frames later as a camera
would have delivered meanwhile."""


@dataclass(frozen=True)
class Method:
    """A composition by name.

    Attributes:
        summary: what it is, with its source.
        parameters: of modalities and optimiser.
        graph: how it follows the assembly graph; None where it tracks every part by itself.
        ablation_of: the method that it is without one of its pieces; empty for others.
    """

    summary: str
    parameters: TrackerParameters = field(default_factory=TrackerParameters)
    graph: GraphParameters | None = None
    ablation_of: str = ""

    @property
    def needs_true_state(self) -> bool:
        """Whether it must be told the assembly state of each frame."""
        return self.graph is not None and self.graph.is_told


@dataclass(frozen=True)
class FrameByFrameMethod(Method):
    """Finds the parts in each frame by itself, with the network in the asset's bundle.

    Attributes:
        uses_depth: whether measured depth fixes a part's distance.
        variant: folder in the bundle that holds the network; empty for the bundle itself.
        frame_step: the benchmark shows it every so-manieth frame: as it remembers nothing, those
            between would tell the same, at the price of hours.
    """

    uses_depth: bool = False
    variant: str = ""
    frame_step: int = 5

    @property
    def modules(self) -> tuple[str, ...]:
        """What it loads beside what all methods share; the benchmark digests it."""
        return (FRAME_BY_FRAME,)

    @property
    def finds_parts(self) -> bool:
        """Whether it finds parts that it was given no pose of."""
        return True

    @property
    def network(self) -> str | None:
        """Folder in the bundle with the network's files, which the benchmark digests too."""
        return self.variant


@dataclass(frozen=True)
class ReinitialisedMethod(Method):
    """Follows the parts with a detector beside, which brings back those that were lost.

    Attributes:
        detector: what finds the parts: the network in the asset's bundle, or shape alone.
        uses_depth: whether shape in the depth image says how what the network finds lies.
        is_published: the rule of the GBOT paper (section 3.3): every 10th frame a part that is
            detected more than 5 cm away is put there, and the tracker waits for the detector;
            elsewhere an answer comes late, by `LATENCIES`.
        is_cold: the benchmark gives it no first poses: it finds the parts by itself.
    """

    detector: Literal["network", "geometric"] = "network"
    uses_depth: bool = True
    is_published: bool = False
    is_cold: bool = False

    @property
    def modules(self) -> tuple[str, ...]:
        """What it loads beside what all methods share; the benchmark digests it."""
        return (REINITIALISED, FINDERS[self.detector])

    @property
    def finds_parts(self) -> bool:
        """Whether it finds parts that it was given no pose of; the published rule does not."""
        return not self.is_published

    @property
    def network(self) -> str | None:
        """Folder in the bundle with the network's files; None for a finder that has none."""
        return "" if self.detector == "network" else None


class MethodTracker(Protocol):
    """What a method gives: a `Tracker`, or what takes its place."""

    names: tuple[str, ...]
    camera: RgbdCamera

    def start(
        self, frame: Frame, camera_from_body: Mapping[str, Pose], *others: Frame | None
    ) -> None:
        """As `Tracker.start`."""

    def set_state(self, state: str) -> None:
        """As `Tracker.set_state`."""

    def track(self, frame: Frame | None, *others: Frame | None) -> TrackingResult:
        """As `Tracker.track`."""
