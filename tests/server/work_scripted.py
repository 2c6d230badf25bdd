"""Runs `snapfit worker` with the scripted pipeline: python work_scripted.py CONFIG."""

from __future__ import annotations

import sys
from pathlib import Path

from snapfit.models.errors import SnapfitError
from snapfit.server.fleet.host import run_workers
from snapfit.server.settings import load_settings


def main() -> int:
    try:
        run_workers(load_settings(Path(sys.argv[1])), print, "scripted_pipeline:open_pipeline")
    except SnapfitError as error:
        sys.stderr.write(f"refused: {error}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
