"""Finds joined parts by the assembly: a link says where a part is, beside one that is known.

In the midst of an assembly most parts are joined: their outlines stand out nowhere, and neither
shape alone nor a network that is unsure tells them apart. But the manifest says where each may sit
on its neighbours. So what another finder leaves is looked for there.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from snapfit.models.asset import Asset
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.finding.finder import CountsRejections, Finder, Hypothesis
from snapfit.tracking.finding.neighbour_search import NeighbourSearch
from snapfit.tracking.finding.open3d_module import open3d
from snapfit.tracking.frame import Frame


class JoinedFinder:
    """Another finder, and what the links say beside what it finds; see `Finder`.

    Args:
        finder: that looks first.
        search: that looks beside what is known then.

    Attributes:
        names: of the parts that the other finder knows.
    """

    def __init__(self, finder: Finder, search: NeighbourSearch) -> None:
        self.names = finder.names
        self._finder, self._search = finder, search

    @property
    def rejected(self) -> Mapping[str, int]:
        """Candidates of the other finder that gave no pose, by reason."""
        return self._finder.rejected if isinstance(self._finder, CountsRejections) else {}

    def find(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> list[Hypothesis]:
        """As `Finder.find`; what the other finder found comes first.

        Raises:
            FrameError, TrackingError: as the other finder does.
        """
        there = dict(known or {})
        missing = [name for name in self.names if name in wanted and name not in there]
        found = self._finder.find(frame, wanted, known)
        found = self._search.twins.named(found, missing, there)
        there |= self._search.assignment.assign(found, missing, there)
        missing = [name for name in missing if name not in there]
        # What is found beside one part may carry the next.
        while missing and there:
            news = self._search.beside(frame, missing, there)
            if not news:
                break
            found += news
            there |= {each.part: each.camera_from_body for each in news}
            missing = [name for name in missing if name not in there]
        return found


def with_links(
    finders: Sequence[tuple[str, Finder]],
    bodies: Sequence[Body],
    camera: RgbdCamera,
    asset: Asset | None,
) -> list[tuple[str, Finder]]:
    """Finders that look in turn, with the links beside; as they are without links or depth.

    Args:
        finders: by the name of their kind.
        bodies: the tracked parts, with their viewpoint models.
        camera: where the frames come from.
        asset: that they belong to, if any.
    """
    if asset is None or camera.depth is None or not any(each.links for each in asset.states):
        return list(finders)
    try:
        open3d()
    except TrackingError:  # whoever needs it has told so
        return list(finders)
    search = NeighbourSearch(bodies, camera, asset)
    return [(kind, JoinedFinder(finder, search)) for kind, finder in finders]
