"""Evidence that a link has come into being, gathered over frames."""

from __future__ import annotations

import math
from dataclasses import dataclass

from snapfit.models.manifest import JointType
from snapfit.models.pose import Array
from snapfit.tracking.assembly.link_error import LinkFit, LinkMeasure
from snapfit.tracking.assembly.parameters import AssemblyParameters


@dataclass(frozen=True)
class Spread:
    """How uncertain a relative pose is: one standard deviation.

    Attributes:
        translation_m: of the translation along one axis.
        rotation_rad: of the rotation about one axis.
    """

    translation_m: float = 0.0
    rotation_rad: float = 0.0


class LinkEvidence:
    """What speaks for one deciding link.

    Any of four is enough: in place within tracking error for a few frames; nearly so, and at rest;
    its joint anywhere in its range, and at rest for long; or, for a part that cannot be measured,
    an image that agrees with a part in its place.

    Attributes:
        measure: how the link is measured.
        fit: the last measurement near the link; None before there is one.
        hidden_frames: frames since parent or child had a trustworthy pose.
    """

    def __init__(self, measure: LinkMeasure, parameters: AssemblyParameters) -> None:
        self.measure = measure
        self.fit: LinkFit | None = None
        self.hidden_frames = 0
        self._parameters = parameters
        self._close = self._near = self._rest = self._supported = 0
        self._denied = 0

    def see(self, parent_from_child: Array, still_frames: int, spread: Spread) -> None:
        """Takes in a measured relative pose.

        Args:
            parent_from_child: (4, 4) running mean.
            still_frames: for how long it has been at rest.
            spread: of a single measurement of it.
        """
        p = self._parameters
        self.hidden_frames = self._denied = 0
        if self.is_far(parent_from_child):
            self._close = self._near = self._rest = 0
            return
        self.fit = self.measure.fit(parent_from_child)
        is_resting = self.fit.is_within(p.rest_m, math.inf) and self.fit.is_within_tolerance
        self._rest = still_frames if is_resting else 0
        is_close, is_near = self._placed(parent_from_child, spread)
        self._close = _counted(self._close, is_close)
        self._near = min(still_frames, self._near + 1) if is_near else 0

    def is_far(self, parent_from_child: Array) -> bool:
        """Whether a relative pose (4, 4) is surely not within the manifest's tolerance; quick."""
        return self.measure.is_far(parent_from_child, self.measure.link.translation_tolerance_m)

    def _placed(self, parent_from_child: Array, spread: Spread) -> tuple[bool, bool]:
        """Whether the child is where the joint has its zero: within tracking error, nearly so."""
        p = self._parameters
        if self.fit is None or not self.fit.is_within_tolerance:
            return False, False
        more_m = min(p.widening * spread.translation_m, p.widest_m)
        more_rad = min(p.widening * spread.rotation_rad, p.widest_rad)
        near_m, near_rad = p.near_m + more_m, p.near_rad + more_rad
        if not self.fit.is_within(near_m, near_rad):
            return False, False
        if self.measure.is_slow:
            travel_m = abs(float(self.fit.q[0])) * abs(self.measure.joint.pitch_m) / math.tau
            return travel_m < p.slow_m, False
        at_zero = self.fit
        if self.measure.joint.n_dof:
            at_zero = self.measure.fit_at_zero(parent_from_child)
        is_close = at_zero.is_within(p.close_m + more_m / 2, p.close_rad + more_rad / 2)
        return is_close, at_zero.is_within(near_m, near_rad)

    def miss(self) -> None:
        """Takes in a frame without a trustworthy pose of parent or child."""
        self.hidden_frames += 1
        self._close = self._near = self._rest = 0

    def ask(self, support: float, parent_from_child: Array | None) -> None:
        """Takes in what the image says of the part in its place, wherever it is tracked.

        Args:
            support: agreement of the image with it, 0 to 1; not a number where it is not seen.
            parent_from_child: (4, 4) that agrees best, near the place.
        """
        p = self._parameters
        if math.isnan(support):
            return
        agrees = support >= p.supported and parent_from_child is not None
        if agrees and parent_from_child is not None:
            agrees = self._is_in_place(parent_from_child)
        self._supported = _counted(self._supported, agrees)
        self._denied = _counted(self._denied, support < 1 - p.supported)

    def _is_in_place(self, parent_from_child: Array) -> bool:
        """Whether a pose at which an image was looked at is that of a child in its place."""
        p, joint = self._parameters, self.measure.joint
        if joint.type is not JointType.SCREW:
            return self.measure.fit_at_zero(parent_from_child).is_within(p.near_m, p.looked_rad)
        fit = self.measure.fit(parent_from_child)
        travel_m = abs(float(fit.q[0])) * abs(joint.pitch_m) / math.tau
        return fit.is_within(p.near_m, p.looked_rad) and travel_m < p.slow_m

    def forget_support(self) -> None:
        """The part is surely seen: what spoke for its place while it was not counts no more."""
        self._supported = 0

    @property
    def is_ready(self) -> bool:
        """Whether the link counts as made."""
        return self.progress >= 1

    @property
    def is_measured(self) -> bool:
        """Whether what makes it ready was measured, not only supported by the image."""
        return self.hidden_frames == 0

    @property
    def is_unknown(self) -> bool:
        """Whether the part has been out of sight for long, and nothing speaks against it."""
        return self.hidden_frames >= self._parameters.unseen_frames and self._denied == 0

    @property
    def progress(self) -> float:
        """How much of what is needed is there, 0 to 1."""
        p = self._parameters
        return min(
            max(
                self._close / (p.slow_frames if self.measure.is_slow else p.close_frames),
                self._near / p.near_frames,
                self._rest / p.rest_frames,
                self._supported / p.supported_frames,
            ),
            1.0,
        )


def _counted(count: int, is_so: bool) -> int:
    """One frame more, or one less: a single frame that disagrees does not begin it anew."""
    return count + 1 if is_so else max(count - 1, 0)
