"""Runs the real server with the scripted pipeline: python serve_scripted.py PORT [GBOT_PORT].

SIGUSR1 sets its wall clock back.
"""

from __future__ import annotations

import signal
import sys

from rich.console import Console
from wall_clock import step_back

from snapfit.models.errors import SnapfitError
from snapfit.server.cli.progress import StartProgress
from snapfit.server.run import run_server
from snapfit.server.settings import make_settings


def main() -> int:
    signal.signal(signal.SIGUSR1, lambda *_: step_back())
    ports = {"port": int(sys.argv[1])}
    if len(sys.argv) > 2:
        ports["gbot_port"] = int(sys.argv[2])
    settings = make_settings("the test", ports)
    try:
        run_server(
            settings, StartProgress(settings, Console()).follow, "scripted_pipeline:open_pipeline"
        )
    except SnapfitError as error:
        sys.stderr.write(f"refused: {error}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
