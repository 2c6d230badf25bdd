"""Keeps a station's worker running: starts it, starts it again when it dies, ends it."""

from __future__ import annotations

import contextlib
import logging
import os
import secrets
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass, replace

from snapfit.server.pose_store import PoseStore
from snapfit.server.schemas import Phase, WorkerReport
from snapfit.server.worker_spec import REFUSED_EXIT_CODE, WorkerSpec

# Time to complete a recording, on a busy machine too.
_END_LIMIT_S = 6.0
_WATCH_PERIOD_S = 0.25
_NOT_STARTED = -1
_LOG = logging.getLogger(__name__)

_ALLOCATOR = {"MALLOC_ARENA_MAX": "1"}
"""glibc gives threads heaps of their own, and each keeps the images that went through it: a third
more memory, and more time to fetch it. The environment may say otherwise."""


@dataclass(frozen=True)
class RestartPolicy:
    """How long to wait before a worker that died is started again.

    A worker that had been tracking is back at once; one that dies before it tracks has to wait
    longer each time.

    Attributes:
        first_delay_s: after the first start that failed.
        longest_delay_s: the delay doubles up to here.
        silence_limit_s: a tracking worker that is silent for so long hangs, and is killed.
    """

    first_delay_s: float = 0.5
    longest_delay_s: float = 30.0
    silence_limit_s: float = 10.0

    def delay_s(self, failed_starts: int) -> float:
        """The delay after so many starts in a row that never came to tracking."""
        if failed_starts == 0:
            return 0.0
        return min(self.first_delay_s * 2.0 ** (failed_starts - 1), self.longest_delay_s)


@dataclass(frozen=True)
class SupervisorStatus:
    """What a supervisor knows of its worker.

    Attributes:
        boot_id: of the run in progress, None while the worker is down.
        pid: its process, None while it is down.
        restarts: how often it was started again.
        last_exit: how it ended the last time.
        refused: a file or a setting is wrong: it is not started again.
        absent: why nothing is known of it now; None where it is watched.
    """

    boot_id: str | None = None
    pid: int | None = None
    restarts: int = 0
    last_exit: str | None = None
    refused: bool = False
    absent: str | None = None


class Supervisor:
    """Runs one worker process after the other, from a thread of its own.

    Args:
        spec: what the worker is told; its boot_id is set anew for each run.
        store: watched for the worker's heartbeat.
        policy: how long to wait before a restart.
    """

    def __init__(
        self, spec: WorkerSpec, store: PoseStore, policy: RestartPolicy | None = None
    ) -> None:
        self.status = SupervisorStatus()
        self._spec = spec
        self._store = store
        self._policy = policy or RestartPolicy()
        self._process: subprocess.Popen[bytes] | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"supervise-{spec.station}")

    def start(self) -> None:
        """Start the worker; returns at once."""
        self._thread.start()

    def close(self) -> None:
        """End the worker and the supervision; returns when both are gone."""
        self._stop.set()
        self._thread.join()

    def _run(self) -> None:
        failed_starts = 0
        while not self._stop.is_set():
            generation = self._store.snapshots.latest
            try:
                exit_code = self._run_once()
            except OSError as error:  # no memory or no process left for it: they may come back
                exit_code = _NOT_STARTED
                last_exit = f"could not be started: {error}"
                self.status = replace(self.status, boot_id=None, pid=None, last_exit=last_exit)
            if self._stop.is_set():
                return
            has_tracked = self._store.snapshots.latest > generation
            failed_starts = 0 if has_tracked else failed_starts + 1
            if exit_code == REFUSED_EXIT_CODE and not self._store.snapshots.latest:
                self.status = replace(self.status, refused=True)
                return
            delay_s = self._policy.delay_s(failed_starts)
            _LOG.error(
                "station %s: the worker %s; starting it again in %g s",
                self._spec.station,
                self.status.last_exit,
                delay_s,
            )
            self._stop.wait(delay_s)
            self.status = replace(self.status, restarts=self.status.restarts + 1)

    def _run_once(self) -> int:
        """Start a worker, wait until it is gone; its exit code."""
        boot_id = secrets.token_hex(6)
        bell = self._store.doorbell.rung
        spec = self._spec.model_copy(update={"boot_id": boot_id, "doorbell": bell})
        self._store.beat()
        # A process group of its own: Ctrl-C in the terminal is the server's to handle.
        with subprocess.Popen(
            [sys.executable, "-m", "snapfit.server.worker"],
            stdin=subprocess.PIPE,
            env={**_ALLOCATOR, **os.environ},
            bufsize=0,
            process_group=0,
            pass_fds=() if bell is None else (bell,),
        ) as process:
            self.status = replace(self.status, boot_id=boot_id, pid=process.pid)
            pipe = process.stdin
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):  # dead already: seen in `_wait`
                    pipe.write(spec.model_dump_json().encode() + b"\n")
            exit_code = self._wait(process, boot_id)
        last_exit = describe_exit(exit_code)
        self.status = replace(self.status, boot_id=None, pid=None, last_exit=last_exit)
        return exit_code

    def _wait(self, process: subprocess.Popen[bytes], boot_id: str) -> int:
        """Until the process is gone: by itself, hung, or because `close` was called."""
        silent_for_s = 0.0
        while not self._stop.is_set():
            with contextlib.suppress(subprocess.TimeoutExpired):
                return process.wait(_WATCH_PERIOD_S)
            # Look by look: when this process was frozen, its worker probably was, too.
            silent_for_s = min(silent_for_s + _WATCH_PERIOD_S, self._store.silent_for_s())
            if silent_for_s > self._policy.silence_limit_s and self._is_tracking(boot_id):
                _LOG.error("station %s: the worker hangs, it is killed", self._spec.station)
                process.kill()
        if process.stdin is not None:
            process.stdin.close()
        try:
            return process.wait(_END_LIMIT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            return process.wait()

    def _is_tracking(self, boot_id: str) -> bool:
        message = self._store.reports.read()
        if message is None:
            return False
        report = WorkerReport.model_validate_json(message.payload)
        return report.boot_id == boot_id and report.phase is not Phase.STARTING


def describe_exit(exit_code: int) -> str:
    """How a process ended, in words."""
    if exit_code < 0:
        with contextlib.suppress(ValueError):  # a real-time signal has a number and no name
            return f"was killed by {signal.Signals(-exit_code).name}"
        return f"was killed by signal {-exit_code}"
    if exit_code == 0:
        return "ended by itself"
    return f"failed with exit code {exit_code}"
