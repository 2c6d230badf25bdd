"""The query of the assembly: after which change it is wanted."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends, Query
from pydantic import BaseModel, ConfigDict, Field

from snapfit.server.routes.pose_query import LARGEST_INTEGER, LONGEST_WAIT_S
from snapfit.server.station import Station
from snapfit.server.waiting import Tell, Waiting


class AssemblyQuery(BaseModel):
    """After which change the assembly is wanted."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    after_revision: Annotated[int, Field(ge=0, le=LARGEST_INTEGER)] | None = Field(
        default=None,
        description="Wait for a change of the assembly after this one of `boot_id`, or until "
        "`stale` changes: 204 if there is none within `timeout_s`.",
    )
    boot_id: str | None = Field(
        default=None,
        max_length=64,
        description="Of what `after_revision` counts from. Without it, any other revision is "
        "waited for.",
    )
    timeout_s: float = Field(
        default=20.0, ge=0, le=LONGEST_WAIT_S, description="How long to wait, seconds."
    )

    async def is_new(self, station: Station) -> bool:
        """Wait for the change that is asked for; False if there is none in time."""
        if self.after_revision is None:
            return True
        return await station.watch.revision_after(self.boot_id, self.after_revision, self.timeout_s)

    def tell_new(self, station: Station, tell: Tell) -> Waiting | None:
        """The same without a task; None where there is nothing to wait for."""
        if self.after_revision is None:
            return None
        watch = station.watch
        return watch.tell_revision_after(self.boot_id, self.after_revision, self.timeout_s, tell)


async def _assembly_query(query: Annotated[AssemblyQuery, Query()]) -> AssemblyQuery:
    return query


WantedAssembly = Annotated[AssemblyQuery, Depends(_assembly_query)]
