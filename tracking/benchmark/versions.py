"""Versions of code and data: a finished run stands as long as neither has changed."""

from __future__ import annotations

import ast
import hashlib
import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from snapfit.models.recording import Recording
from snapfit.tracking.benchmark.roster import entry

_HOUSE = Path(__file__).resolve().parents[2]
_ROOTS = ("contest", "notes", "sequences")
_WORDS = ("summary", "ablation_of")
"""Of a method's entry: it tracks as it does, whatever these say."""

_METHODS = _HOUSE / "tracking" / "methods.py"


def code_version(method: str) -> str:
    """A digest of all code that a method's estimates or their errors depend on.

    That is every module that the benchmark's runs import, directly or not, without comments and
    docstrings; and of the table of methods the method's own entry alone, so that adding a method
    to it leaves the others' runs as they are.
    """
    sha = hashlib.sha256(_shared_version(_ROOTS).encode())
    for module in getattr(entry(method), "modules", ()):
        sha.update(_module_version(module).encode())
    own = {name: value for name, value in vars(entry(method)).items() if name not in _WORDS}
    sha.update(re.sub(r" at 0x[0-9a-f]+", "", repr(own)).encode())
    return sha.hexdigest()[:16]


def imported_files(roots: tuple[str, ...] = _ROOTS) -> set[Path]:
    """Our files that these modules of the benchmark import, directly or not."""
    return _reached([Path(__file__).resolve().with_name(f"{name}.py") for name in roots])


def _reached(waiting: list[Path]) -> set[Path]:
    """These files and all of ours that they import, directly or not."""
    found: set[Path] = set()
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting.extend(_imports_of(path))
    return found


def data_version(recording: Recording) -> str:
    """A digest of a sequence: cameras, truth, parts, assembly, and its images' names and sizes.

    It does not depend on where the sequence lies.
    """
    sha = hashlib.sha256(f"{recording.camera}{recording.frame_rate_hz}".encode())
    if recording.asset is not None:
        sha.update(f"{recording.asset.states}{recording.asset.steps}".encode())
    for part in recording.parts:
        sha.update(f"{part.name}{part.mesh.digest}".encode())
        sha.update(f"{part.symmetry.kind}{len(part.symmetry.motions)}".encode())
    for frame in recording.frames:
        truth = recording.truth[frame.name]
        sha.update(f"{frame.name}{truth.state}{frame.color.stat().st_size}".encode())
        if frame.depth is not None:
            sha.update(str(frame.depth.stat().st_size).encode())
        for part in recording.parts:
            sha.update(truth.camera_from_body[part.name].matrix.tobytes())
    return sha.hexdigest()[:16]


@lru_cache
def _module_version(module: str) -> str:
    """A digest of a module that one method alone loads, and of all that it imports."""
    sha = hashlib.sha256()
    for path in sorted(_reached([_file_of(module)])):
        sha.update(f"{path.relative_to(_HOUSE)}{_versioned(path)}".encode())
    return sha.hexdigest()


@lru_cache
def _shared_version(roots: tuple[str, ...]) -> str:
    """A digest of the code of all methods; read once, as it was loaded."""
    sha = hashlib.sha256()
    for path in sorted(imported_files(roots)):
        sha.update(f"{path.relative_to(_HOUSE)}{_versioned(path)}".encode())
    return sha.hexdigest()


def _file_of(module: str) -> Path:
    return _HOUSE.joinpath(*module.split(".")[1:]).with_suffix(".py")


def _versioned(path: Path) -> str:
    """A file's code; nothing of the table of methods, of which only a method's own entry counts."""
    return "" if path == _METHODS else _code_of(path)


def _imports_of(path: Path) -> Iterator[Path]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("snapfit."):
            base = _HOUSE.joinpath(*str(node.module).split(".")[1:])
            # `from package import module` names files too.
            for each in (base, *(base / alias.name for alias in node.names)):
                for file in (each.with_suffix(".py"), each / "__init__.py"):
                    if file.is_file():
                        yield file


def _code_of(path: Path) -> str:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and _is_text(body[0]):
            del body[0]
    return ast.dump(tree)


def _is_text(node: ast.AST) -> bool:
    """Whether a statement is a text alone: a docstring."""
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )
