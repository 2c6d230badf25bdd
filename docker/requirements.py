"""What an image installs, a requirement a line: requirements.py api, or worker [EXTRA,EXTRA].

Read from pyproject.toml, so that there is one list: `worker` is what `pip install snapfit` brings,
`api` the part of it that the API process imports.
"""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path


def requirements(target: str, extras: list[str]) -> list[str]:
    """The requirements of an image.

    Raises:
        SystemExit: the target or an extra is unknown.
    """
    project = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))
    if target == "api":
        wanted: list[str] = project["dependency-groups"]["api"]
    elif target == "worker":
        wanted = list(project["project"]["dependencies"])
    else:
        sys.exit(f"no image {target!r}: api or worker")
    known: dict[str, list[str]] = project["project"]["optional-dependencies"]
    for extra in extras:
        if extra not in known:
            sys.exit(f"no extra {extra!r} in pyproject.toml; there is {', '.join(known)}")
        wanted = [*wanted, *known[extra]]
    return wanted


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    names = [name for word in sys.argv[2:] for name in word.split(",") if name]
    sys.stdout.write("\n".join(requirements(sys.argv[1], names)) + "\n")
