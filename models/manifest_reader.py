"""Reads `asset.toml` and refuses what cannot be: each error names the file, the key, the remedy."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

from pydantic import ValidationError

from snapfit.models.errors import ManifestError
from snapfit.models.manifest import Link, Manifest, Step, tables
from snapfit.models.validation import describe, field_keys

MANIFEST_NAME = "asset.toml"

# A key of the manifest and what is wrong with it.
Problem = tuple[str, str]


def read_manifest(directory: Path) -> Manifest:
    """Reads and checks the manifest of an asset; touches no mesh.

    Args:
        directory: folder that holds `asset.toml`.

    Raises:
        ManifestError: no such file, no TOML, an unknown key, a value out of bounds, a name that
            does not exist, or states that go round in a circle.
    """
    path = directory / MANIFEST_NAME
    manifest = _parse(path)
    for check in (_unique, _references, _one_parent_each, _graph, _asset_folder):
        for key, problem in check(manifest, path):
            raise ManifestError(path, key, problem)
    return manifest


def _parse(path: Path) -> Manifest:
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        problem = f"no such file: an asset is a folder with an {MANIFEST_NAME} and its meshes"
        raise ManifestError(path, "", problem) from error
    except UnicodeDecodeError as error:
        raise ManifestError(path, "", f"is not UTF-8 text: {error}") from error
    except OSError as error:
        raise ManifestError(path, "", f"cannot be read: {error.strerror}") from error
    except tomllib.TOMLDecodeError as error:
        raise ManifestError(path, "", f"is not valid TOML: {error}") from error
    try:
        return Manifest.model_validate(content)
    except ValidationError as error:
        raise ManifestError(path, *describe(error, field_keys(*tables()))) from error


def _unique(manifest: Manifest, _: Path) -> Iterator[Problem]:
    columns: dict[str, list[str | int]] = {
        "part[{}].name": [part.name for part in manifest.part],
        "part[{}].class_id": [part.class_id for part in manifest.part],
        "state[{}].name": [state.name for state in manifest.state],
        "step[{}].name": [step.name for step in manifest.step],
    }
    for key, values in columns.items():
        repeated = [value for value, count in Counter(values).items() if count > 1]
        for value in repeated:
            last = len(values) - 1 - values[::-1].index(value)
            yield key.format(last), f"{value!r} is there twice: give each its own"


def _references(manifest: Manifest, path: Path) -> Iterator[Problem]:
    parts = [part.name for part in manifest.part]
    states = [state.name for state in manifest.state]
    for i, state in enumerate(manifest.state):
        for j, link in enumerate(state.link):
            yield from _link_problems(f"state[{i}].link[{j}]", link, parts)
    for i, step in enumerate(manifest.step):
        yield from _step_problems(f"step[{i}]", step, parts, states)
        yield from _media_problems(f"step[{i}].media", step.media, path.parent)


def _link_problems(key: str, link: Link, parts: list[str]) -> Iterator[Problem]:
    yield from _unknown(f"{key}.parent", link.parent, "part", parts)
    yield from _unknown(f"{key}.child", link.child, "part", parts)
    if link.parent == link.child:
        yield f"{key}.child", f"{link.child!r} is linked to itself: name another part"


def _step_problems(key: str, step: Step, parts: list[str], states: list[str]) -> Iterator[Problem]:
    yield from _unknown(f"{key}.from_state", step.from_state, "state", states)
    yield from _unknown(f"{key}.to_state", step.to_state, "state", states)
    for k, name in enumerate(step.parts):
        yield from _unknown(f"{key}.parts[{k}]", name, "part", parts)
    for k, annotation in enumerate(step.annotation):
        yield from _unknown(f"{key}.annotation[{k}].part", annotation.part, "part", parts)
    if step.ghost is not None:
        yield from _unknown(f"{key}.ghost.part", step.ghost.part, "part", parts)
        yield from _unknown(f"{key}.ghost.parent", step.ghost.parent, "part", parts)


def _media_problems(key: str, media: Iterable[str], directory: Path) -> Iterator[Problem]:
    for k, address in enumerate(media):
        is_web = address.startswith(("https://", "http://"))
        if not is_web and not (directory / address).is_file():
            yield f"{key}[{k}]", f"no such file: {directory / address}"


def _unknown(key: str, name: str, what: str, known: list[str]) -> Iterator[Problem]:
    if name not in known:
        there = ", ".join(known) or f"none: add a [[{what}]]"
        yield key, f"there is no {what} {name!r}; there are: {there}"


def _one_parent_each(manifest: Manifest, _: Path) -> Iterator[Problem]:
    """Links of a state form trees: a part stands on one other, and never on itself."""
    for i, state in enumerate(manifest.state):
        parents: dict[str, str] = {}
        for j, link in enumerate(state.link):
            if link.child in parents:
                problem = f"{link.child!r} already stands on {parents[link.child]!r} in this state"
                yield f"state[{i}].link[{j}].child", f"{problem}: keep one link"
            parents[link.child] = link.parent
        circle = _circle((child, parent) for child, parent in parents.items())
        if circle:
            yield f"state[{i}].link", f"parts stand on each other in a circle: {circle}"


def _graph(manifest: Manifest, _: Path) -> Iterator[Problem]:
    """States form a directed acyclic graph that starts at the first of them."""
    circle = _circle((step.to_state, step.from_state) for step in manifest.step)
    if circle:
        problem = f"the steps go round in a circle: {circle}; a step goes forward, "
        yield "step", problem + "going back is understood by itself"
    reached = {state.name for state in manifest.state[:1]}
    for _each in manifest.step:
        reached |= {step.to_state for step in manifest.step if step.from_state in reached}
    for i, state in enumerate(manifest.state):
        if state.name not in reached:
            start = manifest.state[0].name
            problem = f"no step leads from {start!r} to {state.name!r}: add one, or remove it"
            yield f"state[{i}].name", problem


def _circle(edges: Iterable[tuple[str, str]]) -> str:
    """A circle among edges (node, predecessor), written out, or an empty text."""
    sorter: TopologicalSorter[str] = TopologicalSorter()
    for node, predecessor in edges:
        sorter.add(node, predecessor)
    try:
        sorter.prepare()
    except CycleError as error:
        return " -> ".join(error.args[1])
    return ""


def _asset_folder(manifest: Manifest, path: Path) -> Iterator[Problem]:
    """Mesh files stay inside the asset's folder, so that a bundle can be handed on whole."""
    root = path.parent.resolve()
    for i, part in enumerate(manifest.part):
        if not (root / part.mesh).resolve().is_relative_to(root):
            yield f"part[{i}].mesh", f"{part.mesh!r} lies outside of the asset: copy it into {root}"
