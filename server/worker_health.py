"""How a worker does: what it says of itself, and what its supervisor knows."""

from __future__ import annotations

from snapfit.server.schemas import Phase, WorkerHealth, WorkerReport
from snapfit.server.supervisor import SupervisorStatus


def worker_health(status: SupervisorStatus, report: WorkerReport | None) -> WorkerHealth:
    """Both together; a report of an earlier run counts for nothing."""
    if report is None or (report.boot_id != status.boot_id and not status.refused):
        # The worker in charge has not spoken yet.
        message = "starting the worker"
        if status.last_exit is not None:
            message = f"the worker {status.last_exit}; starting it again"
        report = WorkerReport(boot_id=status.boot_id or "", phase=Phase.STARTING, message=message)
    absent = status.absent
    return WorkerHealth(
        phase=report.phase if absent is None else Phase.FAILED,
        message=report.message if absent is None else absent,
        progress=report.progress,
        boot_id=status.boot_id,
        pid=status.pid,
        restarts=status.restarts,
        last_exit=status.last_exit,
        frames=report.frames,
        bad_frames=report.bad_frames,
        last_bad_frame=report.last_bad_frame,
        frame_ms=report.frame_ms,
        finding=report.finding,
        recording=report.recording,
    )
