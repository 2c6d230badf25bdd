"""The client's types and openapi/openapi.json say the same, field by field."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path
from typing import Any

import httpx
import pytest
from pydantic import BaseModel

from snapfit.clients.python import anchor, assembly, asset, calls, events, schema, snapshot, station
from snapfit.clients.python.answer import KINDS
from snapfit.clients.python.calls import Call, StationCalls
from snapfit.server.events import EventKind

ROOT = Path(__file__).parents[3]
DOCUMENT = json.loads((ROOT / "openapi" / "openapi.json").read_text(encoding="utf-8"))
SCHEMAS: dict[str, Any] = DOCUMENT["components"]["schemas"]
TYPES: dict[str, type[BaseModel]] = {
    name: each
    for module in (anchor, asset, assembly, schema, snapshot, station)
    for name, each in vars(module).items()
    if isinstance(each, type)
    and issubclass(each, BaseModel)
    and each not in (BaseModel, schema.Schema)
}
BASES = {"SnapshotHeader", "StepHeader"}
# What a program has no use for: a browser's sessions, GBOT's old clients, and what is no type
# of its own in the client (bodies of one or two members, a pose that is given, the error body).
LEFT_OUT = {
    *("SessionInfo", "SessionWish", "GbotPart"),
    *("GivenPose", "ReinitialiseRequest", "StateRequest", "Problem"),
    # ARLEM's own, which players of it read.
    *("Workplace", "Tangible", "Poi", "Detectable", "Sensor", "SensorData", "PrimitiveInfo"),
    *("Activity", "Action", "Instruction", "Transition", "Activate", "Deactivate", "Trigger"),
}
PATHS_LEFT_OUT = {
    *("/v1/session", "/resource", "/metrics"),
    *("/v1/stations/{station}", "/v1/stations/{station}/events", "/v1/events"),
    *("/v1/stations/{station}/frame.mjpeg", "/v1/stations/{station}/overlay.mjpeg"),
    *("/v1/frame.mjpeg", "/v1/overlay.mjpeg"),
    *(f"/v1/assets/{{asset}}/arlem/{name}.json" for name in ("workplace", "activity")),
}


def shape(told: dict[str, Any], known: dict[str, Any]) -> Any:
    """What a JSON schema allows, without words and bounds; references are followed."""
    if "$ref" in told:
        return shape(known[told["$ref"].rpartition("/")[2]], known)
    if "anyOf" in told or "oneOf" in told:
        each = [shape(it, known) for it in told.get("anyOf", told.get("oneOf"))]
        return frozenset(map(repr, each))
    if "properties" in told:
        return {name: shape(it, known) for name, it in told["properties"].items()}
    if told.get("type") == "array":
        items = told["prefixItems"][0] if "prefixItems" in told else told["items"]
        bounds = (told.get("minItems"), told.get("maxItems"))
        return [shape(items, known), bounds if bounds[0] == bounds[1] else None]
    if "enum" in told or "const" in told:
        return sorted(told.get("enum", [told.get("const")]))
    if isinstance(told.get("additionalProperties"), dict):
        return ["object", shape(told["additionalProperties"], known)]
    return told.get("type")


def shape_of_type(name: str) -> Any:
    told = TYPES[name].model_json_schema()
    return shape(told, told.get("$defs", {}))


@pytest.mark.parametrize("name", sorted(set(SCHEMAS) - LEFT_OUT))
def test_every_schema_is_known_field_by_field(name: str) -> None:
    told = SCHEMAS[name]
    if "enum" in told:
        kinds = [vars(module).get(name) for module in (anchor, assembly, schema, snapshot, station)]
        (kind,) = {each for each in kinds if each is not None}
        assert sorted(kind) == sorted(told["enum"])
        return
    assert shape_of_type(name) == shape(told, SCHEMAS)


def test_no_type_is_unknown_to_the_document() -> None:
    assert set(TYPES) - BASES <= set(SCHEMAS)
    assert set(SCHEMAS) >= LEFT_OUT


@pytest.mark.parametrize("name", ["PoseSnapshot", "AssemblyStatus", "StationStep", "StationInfo"])
def test_a_difference_is_noticed(name: str) -> None:
    theirs = shape(SCHEMAS[name], SCHEMAS)
    theirs["new"] = "string"
    assert shape_of_type(name) != theirs


def all_calls() -> list[Call[Any]]:
    request = anchor.anchor_request((0, 0, 0), (0, 0, 0, 1))
    found: list[Call[Any]] = [
        *(calls.stations(), calls.assets(), calls.asset("a", "unity"), calls.part_model("a", "p")),
        *(calls.media("/v1/assets/a/media/m"), calls.server_time(0), calls.health()),
        calls.ready(),
    ]
    for name in (None, "s"):
        it = StationCalls(name)
        found += [
            *(it.poses("unity", "anchor:a", 0), it.pose("p", "unity", "anchor:a", 0)),
            *(it.next_poses("b", 1, "unity", "anchor:a", 1), it.assembly()),
            *(it.next_assembly("b", 1, 1), it.steps("unity", "anchor:a")),
            *(it.step("s", "unity", "anchor:a"), it.step("current", "unity", "anchor:a")),
            *(it.reset(), it.reinitialise(["p"]), it.set_state("s"), it.anchors("unity")),
            *(it.anchor("a", "unity"), it.put_anchor("a", request), it.delete_anchor("a")),
            *(it.picture("frame"), it.picture("overlay")),
        ]
    return found


def operation_of(call: Call[Any]) -> tuple[str, Any] | None:
    """The path as the document has it, and the operation; the most literal one that fits."""
    fitting = [
        path
        for path, operations in DOCUMENT["paths"].items()
        if call.method.lower() in operations
        and re.fullmatch(re.sub(r"\\{\w+\\}", "[^/]+", re.escape(path)), call.path)
    ]
    if not fitting:
        return None
    path = min(fitting, key=lambda each: each.count("{"))
    return path, DOCUMENT["paths"][path][call.method.lower()]


@pytest.mark.parametrize("call", all_calls(), ids=lambda call: f"{call.method} {call.path}")
def test_every_call_is_in_the_document_with_its_query_and_body(call: Call[Any]) -> None:
    found = operation_of(call)
    assert found is not None
    _, operation = found
    parameters = operation.get("parameters", [])
    assert set(call.query) <= {it["name"] for it in parameters if it["in"] == "query"}
    assert (call.body is None) or "requestBody" in operation


def test_every_operation_of_the_document_can_be_called() -> None:
    wanted = {
        (method.upper(), path)
        for path, operations in DOCUMENT["paths"].items()
        for method in operations
        if path not in PATHS_LEFT_OUT
    }
    found = [(call, operation_of(call)) for call in all_calls()]
    assert wanted == {(call.method, it[0]) for call, it in found if it is not None}


def test_names_are_one_segment_of_a_path() -> None:
    url = httpx.URL("http://h" + StationCalls("a/../b").pose("c?d", "opencv", "camera", None).path)
    assert url.raw_path == b"/v1/stations/a%2F..%2Fb/poses/c%3Fd"


def kinds_of_problems() -> set[str]:
    """Every kind that the server's code names."""
    found = set()
    for path in (ROOT / "server").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                place = {"ProblemError": 1, "_refused": 1}.get(node.func.id)
                argument = node.args[place] if place and len(node.args) > place else None
                if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
                    found.add(argument.value)
    return found


def test_every_kind_of_problem_has_a_class() -> None:
    assert len(kinds_of_problems()) > 25
    # "bug" has the class of its status; "old-port" is what GBOT's old clients are told.
    assert kinds_of_problems() - {"bug", "old-port"} == set(KINDS)


def test_every_kind_of_event_has_a_class() -> None:
    names = {each.event for each in vars(events).values() if hasattr(each, "event")} - {""}
    assert names == {*EventKind, "missed"}
