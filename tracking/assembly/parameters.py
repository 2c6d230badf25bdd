"""Thresholds of the assembly state, each with its reason. Counts are frames at 30 a second."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class AssemblyParameters:
    """When a state is left, in either direction, and what counts as put together wrongly.

    Hands move parts at about 3 mm and 1.5 degrees a frame; the tracker is off by 1 to 3 mm and
    degrees. A part that only passes its place is within the manifest's tolerance (3 cm and 10
    degrees) for up to 20 frames, but never at rest and never within 5 mm for more than 3.

    Attributes:
        thresholds_alone: switch as soon as the manifest's tolerance is met, forward only, with
            rigid links: what the GBOT paper does (section 3.3). Ignores all that follows.
        smoothing: weight of a new relative pose in its running mean; 0.35 halves white noise at a
            lag of two frames.
        jump_m: a relative pose that jumps by more starts its mean anew (a part found again).
        jump_rad: the same for its rotation.
        close_m: in place within tracking error: counts at once.
        close_rad: the same for the rotation.
        close_frames: so long, against a lucky pass.
        near_m: in place if it also stands still there: a screw between two turns of the hand is
            2.5 mm away, and a noisy part may look as if it were.
        near_rad: the same for the rotation.
        near_frames: so long at rest.
        looked_rad: where the image is asked about a part of which little is seen, it is in its
            place if it agrees best this near to it.
        slow_m: a screw whose turn cannot be seen advances 2 or 3 mm while the hand turns it once
            and takes a new hold, so it only counts when its travel is done to less than that.
        slow_frames: and so long.
        widening: how many standard deviations of the estimate widen both.
        widest_m: but never by more.
        widest_rad: the same for the rotation.
        rest_m: joined with its joint anywhere in its range, if it stays there.
        rest_frames: so long: hands pause for up to 12 frames between two turns of a screw.
        still_m: a relative pose that leaves its mean by less is at rest.
        still_rad: the same for the rotation.
        least_confidence: a tracked part below it is as good as hidden.
        least_visibility: a part of which less is seen cannot contradict its link.
        hidden_frames: a part without a trustworthy pose for so long is looked for in its place.
        unseen_frames: out of sight for so long, a part is taken to be in its place once the step
            after the next is seen to be done.
        supported: agreement of the image with a part in its place that speaks for it.
        supported_frames: so often.
        undone_share: a link is contradicted when the part's own pose is this many times the
            manifest's tolerance away: far more than `near_m`, so that nothing flickers.
        undone_frames: so long.
        absent_frames: a part that is nowhere found has come off when its place was seen without it
            for so long: a joint that was turned behind a hand is found again before.
        hold_frames: so long an operator's word stands against the evidence of that moment.
        wrong_frames: a part at the wrong place counts after 0.7 s at rest.
        sure_share: and only if the poses of both were beyond doubt for so much of that time.
        moved_m: and only if it has been moved by so much before.
        moved_rad: or turned by so much.
        contact_m: surfaces touch when they are nearer than this: clearance, tracking error and the
            gaps between the samples.
        fulfilled_m: a part nearer to its place is not wrong, only not recognised yet.
        right_m: a wrong part that is put right leaves its wrong place by so much.
        right_rad: or is turned by so much.
    """

    thresholds_alone: bool = False
    smoothing: float = 0.35
    jump_m: float = 0.05
    jump_rad: float = np.radians(35)
    close_m: float = 0.0025
    close_rad: float = np.radians(4)
    close_frames: int = 3
    near_m: float = 0.005
    near_rad: float = np.radians(6)
    near_frames: int = 5
    looked_rad: float = np.radians(8)
    slow_m: float = 0.0018
    slow_frames: int = 8
    widening: float = 1.0
    widest_m: float = 0.003
    widest_rad: float = np.radians(3)
    rest_m: float = 0.008
    rest_frames: int = 45
    still_m: float = 0.004
    still_rad: float = np.radians(4)
    least_confidence: float = 0.3
    least_visibility: float = 0.3
    hidden_frames: int = 3
    unseen_frames: int = 15
    supported: float = 0.7
    supported_frames: int = 6
    undone_share: float = 1.2
    undone_frames: int = 6
    absent_frames: int = 15
    hold_frames: int = 90
    wrong_frames: int = 21
    sure_share: float = 0.6
    moved_m: float = 0.02
    moved_rad: float = np.radians(25)
    contact_m: float = 0.0045
    fulfilled_m: float = 0.01
    right_m: float = 0.01
    right_rad: float = np.radians(15)


GBOT_PAPER = AssemblyParameters(thresholds_alone=True)
