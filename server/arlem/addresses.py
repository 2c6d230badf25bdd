"""Where the things are that ARLEM's documents refer to."""

from __future__ import annotations

from dataclasses import dataclass
from urllib.parse import quote

WORKPLACE_NAME, ACTIVITY_NAME = "workplace.json", "activity.json"


@dataclass(frozen=True)
class Addresses:
    """How one document tells where everything else is.

    Attributes:
        server: that serves meshes, media and the assembly's state, such as http://127.0.0.1:8000.
        station: whose assembly state leads from step to step; the server's only one if None.
        workplace: address of the workplace model.
        activity: address of the activity model.
    """

    server: str
    station: str | None
    workplace: str
    activity: str

    @classmethod
    def served(cls, server: str, asset: str, station: str, query: str) -> Addresses:
        """Of documents that the server itself serves; both are asked for with the same query."""
        folder = f"{server}/v1/assets/{quote(asset)}/arlem"
        end = f"?{query}" if query else ""
        return cls(
            server, station, f"{folder}/{WORKPLACE_NAME}{end}", f"{folder}/{ACTIVITY_NAME}{end}"
        )

    @classmethod
    def of_files(cls, server: str, asset: str, station: str | None) -> Addresses:
        """Of two files that lie side by side."""
        return cls(server, station, f"{asset}-{WORKPLACE_NAME}", f"{asset}-{ACTIVITY_NAME}")

    @property
    def assembly(self) -> str:
        """Where the assembly's state is told."""
        if self.station is None:
            return f"{self.server}/v1/assembly"
        return f"{self.server}/v1/stations/{quote(self.station)}/assembly"

    def absolute(self, address: str) -> str:
        """A path of the server with its address; what is an address already as it is."""
        return address if "://" in address else f"{self.server}{address}"
