"""Follows docker/Dockerfile in roots of Debian bookworm, without Docker.

Each stage has a root of its own, so that a system package that only the build has is missed where
it is missing. The base is Debian's own Python 3.11 in place of the Python image's, which is the
same Debian with a Python under /usr/local; all else is what the Dockerfile says.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from compose_file import ROOT
from dockerfile import Stage, read_dockerfile

# What the Python image has of Debian beside Python itself, and the names it gives to it.
_PACKAGES = "ca-certificates,python3,python3-pip,python3-venv,python-is-python3"
_CERTIFICATES = Path("/etc/ssl/certs")
_STEP_LIMIT_S = 1500
_PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
# How this machine reaches its registry, if not straight; no image has it.
_PIP = {name: value for name, value in os.environ.items() if name in ("PIP_CERT", "PIP_INDEX_URL")}


def make_base(folder: Path) -> Path:
    """A minimal Debian bookworm with Python; `SNAPFIT_DEBIAN_ROOT` names one that is there."""
    given = os.environ.get("SNAPFIT_DEBIAN_ROOT")
    if given is not None:
        return Path(given)
    root = folder / "debian"
    _run(
        "debootstrap", "--foreign", "--variant=minbase", f"--include={_PACKAGES}", "bookworm", root
    )
    # It is thrown away: no package has to be on the disk before the next one.
    careless = root / "etc/dpkg/dpkg.cfg.d/unsafe-io"
    careless.parent.mkdir(parents=True, exist_ok=True)
    careless.write_text("force-unsafe-io\n")
    _run("chroot", root, "/debootstrap/debootstrap", "--second-stage")
    return root


@dataclass
class Image:
    """A root as its stage has left it.

    Attributes:
        root: the folder.
        environment: by ENV.
        workdir: by WORKDIR.
    """

    root: Path
    environment: dict[str, str] = field(default_factory=lambda: {"PATH": _PATH})
    workdir: str = "/"

    def path(self, place: str) -> Path:
        """A place inside, relative ones from the working directory."""
        return self.root / str(Path(self.workdir) / place).lstrip("/")


class Builder:
    """Builds stages as Docker would, each once.

    Args:
        base: of `make_base`.
        folder: for the roots.
        arguments: in place of the defaults of ARG.
    """

    def __init__(self, base: Path, folder: Path, arguments: dict[str, str]) -> None:
        self._base = base
        self._folder = folder
        self._arguments = arguments
        self._stages = read_dockerfile()
        self._built: dict[str, Image] = {}

    def build(self, name: str) -> Image:
        """The image of a stage."""
        if name not in self._built:
            self._built[name] = self._follow(self._stages[name])
        return self._built[name]

    def _follow(self, stage: Stage) -> Image:
        image = self._begin(stage)
        arguments: dict[str, str] = {}
        for name, rest in stage.instructions:
            if name == "ENV":
                for pair in shlex.split(rest):
                    key, value = pair.split("=", 1)
                    image.environment[key] = value.replace("$PATH", image.environment["PATH"])
            elif name == "ARG":
                key, _, value = rest.partition("=")
                arguments[key] = self._arguments.get(key, value)
            elif name == "WORKDIR":
                image.workdir = rest
                image.path(".").mkdir(parents=True, exist_ok=True)
            elif name == "COPY":
                self._copy(image, shlex.split(rest))
            elif name == "RUN":
                command = re.sub(r"^(--mount=\S+ )*", "", rest)
                step(image, command, arguments)
        return image

    def _begin(self, stage: Stage) -> Image:
        root = self._folder / stage.name
        if stage.parent not in self._stages:
            _run("cp", "--archive", "--reflink=auto", self._base, root)
            shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")
            return Image(root)
        parent = self.build(stage.parent)
        _run("cp", "--archive", "--reflink=auto", parent.root, root)
        return Image(root, dict(parent.environment), parent.workdir)

    def _copy(self, image: Image, words: list[str]) -> None:
        origin = ROOT
        if words[0].startswith("--from="):
            origin = self.build(words.pop(0).removeprefix("--from=")).root
        *sources, target = words
        place = image.path(target)
        for source in sources:
            found = origin / source.lstrip("/")
            into = place / found.name if target.endswith("/") else place
            into.parent.mkdir(parents=True, exist_ok=True)
            if found.is_dir():
                ignore = shutil.ignore_patterns("__pycache__")
                shutil.copytree(found, into, symlinks=True, ignore=ignore, dirs_exist_ok=True)
            else:
                shutil.copy(found, into)


def step(image: Image, command: str, arguments: dict[str, str] | None = None) -> None:
    """One RUN, as root, with pip's cache of this machine.

    Raises:
        AssertionError: it failed; with all that it said.
    """
    cache = Path.home() / ".cache" / "pip"
    cache.mkdir(parents=True, exist_ok=True)
    mounts = [f"mount --bind {cache} {image.root}/root/.cache/pip", *_system(image)]
    for place in (image.root / "root/.cache/pip", image.path(str(_CERTIFICATES))):
        place.mkdir(parents=True, exist_ok=True)
    environment = {**_PIP, **image.environment, **(arguments or {})}
    inside = _inside(image, environment, ["sh", "-ec", command])
    _run("unshare", "--mount", "sh", "-ec", "; ".join([*mounts, shlex.join(inside)]))


def start(
    image: Image,
    command: list[str],
    environment: dict[str, str],
    mounts: dict[str, str],
    log: IO[str] | None = None,
) -> subprocess.Popen[str]:
    """Start a container's command as Compose has it: the user of the image, a root that cannot be
    written, no capability, no new privileges.

    Args:
        image: of a target.
        command: and its arguments.
        environment: over the image's.
        mounts: by place: a folder (":ro" after it for one that is not to be written), or "tmpfs".
        log: for what it prints; a pipe if none is given.
    """
    root = image.root
    steps = [f"mount --bind {root} {root}", f"mount -o remount,ro,bind {root}", *_system(image)]
    for place, source in mounts.items():
        folder, _, how = source.partition(":")
        if folder == "tmpfs":
            steps.append(f"mount -t tmpfs -o mode=1777 tmpfs {root}{place}")
            continue
        steps.append(f"mount --bind {folder} {root}{place}")
        if how:
            steps.append(f"mount -o remount,ro,bind {root}{place}")
    user = (
        "setpriv --reuid 10001 --regid 10001 --clear-groups --no-new-privs "
        "--bounding-set=-all --inh-caps=-all"
    )
    inside = _inside(image, {**image.environment, **environment}, [*user.split(), *command])
    return subprocess.Popen(
        ["unshare", "--mount", "sh", "-ec", "; ".join([*steps, "exec " + shlex.join(inside)])],
        stdout=subprocess.PIPE if log is None else log,
        stderr=subprocess.STDOUT,
        text=True,
    )


def megabytes(folder: Path) -> float:
    """How much the files in a folder hold, in units of 10^6 bytes."""
    return sum(path.lstat().st_size for path in folder.rglob("*") if not path.is_dir()) / 1e6


def _system(image: Image) -> list[str]:
    """The mounts that every container has."""
    return [
        f"mount --bind /dev {image.root}/dev",
        f"mount -t tmpfs -o mode=1777 tmpfs {image.root}/dev/shm",
        f"mount -t proc proc {image.root}/proc",
        f"mount --bind {_CERTIFICATES} {image.root}{_CERTIFICATES}",
    ]


def _inside(image: Image, environment: dict[str, str], command: list[str]) -> list[str]:
    pairs = [f"{name}={value}" for name, value in environment.items()]
    enter = ["chroot", str(image.root), "env", "-i", f"--chdir={image.workdir}"]
    return [*enter, *pairs, *command]


def _run(*command: str | Path) -> None:
    done = subprocess.run(
        [str(word) for word in command],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        stdin=subprocess.DEVNULL,
        text=True,
        timeout=_STEP_LIMIT_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:]
