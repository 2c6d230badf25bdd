"""The numeric parameters of the geometric finder, and of a tracker that finds its parts."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class CloudParameters:
    """How a depth image becomes points, and points become clusters.

    Attributes:
        stride_px: every so many-th pixel of a row and of a column is taken.
        farthest_m: what is farther away is left out.
        plane_tolerance_m: how far a point of the plane may lie from it.
        plane_rounds: triples of points that RANSAC tries.
        plane_share: of the points, for them to be a plane that things lie on.
        least_rise_m: how far a point of a thing rises above the plane at least, ...
        rise_deviations: ... and how many standard deviations of the plane's own points.
        neighbour_m: points of a cluster are this near to one another (DBSCAN).
        neighbours: that a point inside a cluster has (DBSCAN).
        least_points: of a cluster.
        gap_m: clusters this near to one another may be one thing: its depth may have gaps.
    """

    stride_px: int = 3
    farthest_m: float = 1.5
    plane_tolerance_m: float = 0.005
    plane_rounds: int = 300
    plane_share: float = 0.25
    least_rise_m: float = 0.0025
    rise_deviations: float = 4.0
    neighbour_m: float = 0.008
    neighbours: int = 6
    least_points: int = 40
    gap_m: float = 0.025


@dataclass(frozen=True)
class ProposalParameters:
    """How poses of a part are proposed for a cluster.

    Attributes:
        coarse_views: of the viewpoint model that are all compared: the first ones are a grid.
        fine_views: among which the neighbours of the best are compared: a finer grid.
        around_deg: how far those neighbours are away.
        turns: about the line of sight, evenly.
        surface_points, contour_points: of a view that are compared.
        reach_m: an error counts as much at most.
        area_ratio: between the cluster's area in the image and that of a view, at most.
        followed: best poses of the coarse grid whose neighbours are compared.
        kept: poses a cluster and part.
        apart_deg: by which they differ.
    """

    coarse_views: int = 162
    fine_views: int = 642
    around_deg: float = 13.0
    turns: int = 24
    surface_points: int = 30
    contour_points: int = 40
    reach_m: float = 0.015
    area_ratio: float = 1.8
    followed: int = 16
    kept: int = 6
    apart_deg: float = 20.0


@dataclass(frozen=True)
class BoxParameters:
    """How views of a part are fitted into a box that the network says.

    Attributes:
        turns: about the line of sight, evenly.
        size_ratio: between the sides of a view's box and the network's, at most.
        open_ratio: the same, of sides of which an end may be hidden.
        reach_m: an error counts as much at most; what is so much nearer hides the part.
        hidden_share: of it, that a hidden point counts.
        box_weight_m: of the difference between the boxes.
        followed: best poses of the coarse grid whose neighbours are compared.
        kept: poses a region.
    """

    turns: int = 24
    size_ratio: float = 1.5
    open_ratio: float = 2.5
    reach_m: float = 0.015
    hidden_share: float = 0.5
    box_weight_m: float = 0.02
    followed: int = 16
    kept: int = 6


@dataclass(frozen=True)
class GeometricParameters:
    """All of the geometric finder.

    Attributes:
        cloud: from the depth image to clusters.
        proposals: from clusters to poses.
        tried: poses of a part that are refined.
        tried_clusters: clusters on which they lie, at most.
        least_score: the share of lines and points that agree with a pose, times the overlap of its
            image and the cluster's, that is reported. Parts on their own bench reach more than
            0.7, those that lie on none 0.66 at most.
        least_evidence: lines and points that took part.
        deepest_m: how far a part may reach into the plane.
    """

    cloud: CloudParameters = field(default_factory=CloudParameters)
    proposals: ProposalParameters = field(default_factory=ProposalParameters)
    tried: int = 16
    tried_clusters: int = 4
    least_score: float = 0.7
    least_evidence: int = 100
    deepest_m: float = 0.008


@dataclass(frozen=True)
class GuidedParameters:
    """All of the finder that a network guides, but the network's own.

    Attributes:
        cloud: from the depth image to points that rise above the bench.
        views: of the viewpoint models.
        box: how they are fitted into the network's boxes.
        least_tried, clear_score: so many poses of a region are refined at least; after that no
            more, if one of them scores so much.
        hopeless_score: where none scores so much, none is refined further.
        least_score: that is told (see `Verdict.score`).
        open_score: of the network, from which on a box that no view fits may be that of the
            visible piece alone.
        least_evidence: lines and points that took part.
        deepest_m: how far a part may reach into the plane.
    """

    cloud: CloudParameters = field(default_factory=CloudParameters)
    views: ProposalParameters = field(default_factory=ProposalParameters)
    box: BoxParameters = field(default_factory=BoxParameters)
    least_tried: int = 3
    clear_score: float = 0.85
    hopeless_score: float = 0.35
    least_score: float = 0.65
    open_score: float = 0.45
    least_evidence: int = 100
    deepest_m: float = 0.012


@dataclass(frozen=True)
class JoinedParameters:
    """All of looking for parts where links put them.

    Attributes:
        cloud: from the depth image to points that rise above the bench.
        agrees_m: measured depth agrees with a drawn surface that is no farther off.
        differs_m: what is so far from a known part is not explained by it.
        through_m, through: a place is left out where depth is so much farther than such a share of
            the part's corners.
        least_pixels: of the cloud, in which the part can be seen.
        least_seen: share of its surface that nothing unknown hides.
        least_fit: share of what is seen that agrees.
        least_needed: share of what agrees that nothing known explains.
        least_confidence: of the refined pose: lines and points that agree.
        stays_m, stays_rad: a refinement that leads farther from the place is not taken.
        close_m, least_close: such a share of what is seen is so near to what is measured at last.
    """

    cloud: CloudParameters = field(default_factory=CloudParameters)
    agrees_m: float = 0.008
    differs_m: float = 0.006
    through_m: float = 0.015
    through: float = 0.3
    least_pixels: int = 20
    least_seen: float = 0.5
    least_fit: float = 0.8
    least_needed: float = 0.35
    least_confidence: float = 0.5
    stays_m: float = 0.01
    stays_rad: float = 0.2
    close_m: float = 0.004
    least_close: float = 0.75


@dataclass(frozen=True)
class SelfStartParameters:
    """When parts are looked for, and when they count as found.

    Attributes:
        every_frames: how often the finder looks while all parts are seen.
        trial_frames: so long after its start a part is on trial: ...
        least_confidence: ... with less than this it is searched for again.
        sure_confidence: of a part that is seen; others are looked for at once.
        same_m, same_rad: a find that is no farther from where a part is seen tells nothing new.
        given_up_frames: so long lost, a part starts where it is found, as if it had never been
            seen: its colours may have changed with the light. Until then a find is tried out only.
        doubt_frames: where the tracker cannot try poses out, a part that is seen badly for so long
            starts where it is found.
    """

    every_frames: int = 10
    trial_frames: int = 5
    least_confidence: float = 0.5
    sure_confidence: float = 0.5
    same_m: float = 0.01
    same_rad: float = 0.17
    given_up_frames: int = 90
    doubt_frames: int = 10
