"""What a worker is told when it is started, on its standard input."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict

from snapfit.server.logs.setup import LogFormat, LogLevel
from snapfit.tracking.finding.names import DetectorWish, ProviderName

DEFAULT_PIPELINE = "snapfit.server.open_pipeline:open_pipeline"

DEMO_SOURCE = "demo"
"""The source that is no folder but the simulated bench."""

AUTO: Literal["auto"] = "auto"
"""The method or the detector that suits what there is."""

ColorFormat = Literal["png", "jpeg"]
"""Of colour images in recordings."""

REFUSED_EXIT_CODE = 3
"""A worker that ends with this was refused by a file or a setting; starting it again is vain."""


class WorkerSpec(BaseModel):
    """One run of a worker.

    Attributes:
        station: the station's name.
        source: a camera's address, a path, or "demo" for the simulated bench.
        asset: name or folder of the asset; None: as the source says.
        calibration: camera file; None for sources that bring their calibration.
        method: the tracking method, or "auto".
        detector: what finds the parts.
        providers: what runs a network, the first choice first.
        record: folder for recordings; None to record nothing.
        record_color: format of colour images in them.
        niceness: by how much the worker is less urgent than other programs.
        boot_id: names this run.
        wall_minus_monotonic_ns: the server's time line, see `snapfit.server.clock`.
        poses_segment, pictures_segment: names of the pose store.
        doorbell: of the store, an inherited file descriptor; None without one.
        pipeline: "module:function" that opens source and tracker, see `snapfit.server.pipeline`.
        log_format, log_level: as the server logs.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    station: str
    source: str
    asset: str | None
    method: str
    detector: DetectorWish = "none"
    providers: tuple[ProviderName, ...] = ("cpu",)
    calibration: str | None = None
    record: str | None = None
    record_color: ColorFormat = "png"
    niceness: int = 0
    boot_id: str
    wall_minus_monotonic_ns: int
    poses_segment: str
    pictures_segment: str
    doorbell: int | None = None
    pipeline: str = DEFAULT_PIPELINE
    log_format: LogFormat = "text"
    log_level: LogLevel = "warning"
