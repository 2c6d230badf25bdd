"""ARLEM: whatever is referred to exists, every step is there, over HTTP as well."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness import Server
from test_api import assert_problem

from snapfit.models.asset import find_asset
from snapfit.server.arlem.activity import CHOICE, activity_of
from snapfit.server.arlem.addresses import Addresses
from snapfit.server.arlem.schemas import Activity, Workplace
from snapfit.server.arlem.workplace import workplace_of
from snapfit.server.asset_export import asset_info
from snapfit.server.asset_library import step_along
from snapfit.server.conventions import AXES, Convention
from snapfit.server.errors import NoStepsError
from snapfit.server.schemas_assembly import AssetInfo, StateInfo, StepInfo

ASSETS = ("hobby-corner-clamp", "geared-caliper", "liftpod", "nano-chuck", "hand-screw-clamp")
SERVER = "http://192.168.100.200:8000"
PATH = "/v1/assets/scripted-asset/arlem"
DOCUMENT = json.loads((Path(__file__).parents[2] / "openapi" / "openapi.json").read_text())


@cache
def info_of(name: str) -> AssetInfo:
    return asset_info(find_asset(name))


def models_of(info: AssetInfo) -> tuple[dict[str, Any], dict[str, Any]]:
    """Workplace and activity as they are served."""
    addresses = Addresses.served(SERVER, info.asset, "bench-1", "")
    models = (workplace_of(info, addresses), activity_of(info, addresses, "en"))
    workplace, activity = (
        json.loads(model.model_dump_json(by_alias=True, exclude_none=True)) for model in models
    )
    return workplace, activity


def statements(activity: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """All that is activated or deactivated."""
    for action in activity["actions"]:
        for moment in (action["enter"], action["exit"]):
            yield from (*moment["activates"], *moment["deactivates"])


def assert_every_reference_is_found(workplace: dict[str, Any], activity: dict[str, Any]) -> None:
    tangibles = {each["id"]: each for each in (*workplace["things"], *workplace["places"])}
    detectables = {each["id"] for each in workplace["detectables"]}
    primitives = {each["id"] for each in workplace["primitives"]}
    actions = {each["id"] for each in activity["actions"]}
    keys = {it["id"]: {data["key"] for data in it["data"]} for it in workplace["sensors"]}
    assert activity["workplace"] == workplace["id"]
    assert workplace["origin"] in detectables
    assert {each["detectable"] for each in tangibles.values()} <= detectables
    for each in statements(activity):
        assert each["target"] in tangibles
        if each["type"] == "action":
            assert each["augmentation"] in actions
        else:
            assert each["augmentation"] in primitives
            assert each["poi"] in {poi["id"] for poi in tangibles[each["target"]]["pois"]}
    for action in activity["actions"]:
        assert action["location"] in tangibles
        for trigger in action["triggers"]:
            known = keys if trigger["mode"] == "sensor" else actions
            assert trigger["id"] in known
            assert trigger["mode"] == "click" or trigger["key"] in keys[trigger["id"]]


def reached_from_start(activity: dict[str, Any]) -> set[str]:
    actions = {action["id"]: action for action in activity["actions"]}
    found, waiting = set(), [activity["start"]]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            moments = (actions[name]["enter"], actions[name]["exit"])
            begun = (each for moment in moments for each in moment["activates"])
            waiting += [each["augmentation"] for each in begun if each["type"] == "action"]
    return found


@pytest.mark.parametrize("name", ASSETS)
def test_everything_that_is_referred_to_exists(name: str) -> None:
    workplace, activity = models_of(info_of(name))
    assert_every_reference_is_found(workplace, activity)
    for kind in ("things", "detectables", "primitives", "sensors", "places"):
        names = [each["id"] for each in workplace[kind]]
        assert len(set(names)) == len(names) > 0
    assert max(len(workplace["id"]), len(activity["id"])) <= 100


@pytest.mark.parametrize("name", ASSETS)
def test_every_step_is_there_once_and_can_be_reached(name: str) -> None:
    info = info_of(name)
    _, activity = models_of(info)
    names = [action["id"] for action in activity["actions"]]
    assert names == [step.step for step in info.steps]
    assert activity["start"] == info.steps[0].step
    assert reached_from_start(activity) == set(names)


@pytest.mark.parametrize("name", ASSETS)
def test_every_part_ghost_and_annotation_is_there(name: str) -> None:
    info = info_of(name)
    workplace, activity = models_of(info)
    assert [thing["id"] for thing in workplace["things"]] == [part.part for part in info.parts]
    tracked = {each["id"] for each in workplace["detectables"][1:] if "sensor" in each}
    assert tracked == {part.part for part in info.parts if part.tracked}
    meshes = {part.part: f"{SERVER}{part.mesh}" for part in info.parts}
    for step, action in zip(info.steps, activity["actions"], strict=True):
        shown = action["enter"]["activates"]
        ghosts = [each["url"] for each in shown if each["augmentation"] == "animation"]
        assert ghosts == ([] if step.ghost is None else [meshes[step.ghost.part]])
        labels = [(it["target"], it["text"]) for it in shown if it["augmentation"] == "label"]
        assert labels == [(each.part, each.text) for each in step.annotations]
        ended = {(it["target"], it["poi"]) for it in action["exit"]["deactivates"]}
        assert ended == {(it["target"], it["poi"]) for it in shown}


@pytest.mark.parametrize("name", ASSETS)
def test_a_ghost_lies_where_the_step_says_in_unity_axes(name: str) -> None:
    info = info_of(name)
    workplace, _ = models_of(info)
    things = {thing["id"]: thing for thing in workplace["things"]}
    for step in info.steps:
        ghost = step_along(AXES[Convention.UNITY], step).ghost
        assert ghost is not None
        pois = {poi["id"]: poi for poi in things[ghost.parent]["pois"]}
        poi = pois[f"{step.step}.ghost"]
        offset_m = [float(poi[f"{axis}-offset"]) / 100 for axis in "xyz"]
        np.testing.assert_allclose(offset_m, ghost.position, atol=6e-6)
        x, y, z = (about(axis, float(poi[f"{axis}-rotation"])) for axis in "xyz")
        np.testing.assert_allclose(y @ x @ z, rotation(ghost.orientation), atol=3e-5)


def about(axis: str, angle_deg: float) -> np.ndarray:
    half_rad = math.radians(angle_deg) / 2
    quaternion = [0.0, 0.0, 0.0, math.cos(half_rad)]
    quaternion["xyz".index(axis)] = math.sin(half_rad)
    return rotation(quaternion)


def rotation(quaternion: list[float]) -> np.ndarray:
    x, y, z, w = quaternion
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def test_the_shape_of_a_small_one() -> None:
    workplace, activity = models_of(info_of("hobby-corner-clamp"))
    folder = f"{SERVER}/v1/assets/hobby-corner-clamp"
    assert {key: activity[key] for key in activity if key != "actions"} == {
        "id": f"{folder}/arlem/activity.json",
        "name": "Hobby Corner Clamp",
        "description": "Assembly of Hobby Corner Clamp, step by step.",
        "language": "en",
        "workplace": f"{folder}/arlem/workplace.json",
        "start": "mount-jaw",
    }
    first = activity["actions"][0]
    assert first["instruction"]["title"] == "Slide the jaw into the base"
    ghost = {
        "target": "base",
        "type": "primitive",
        "augmentation": "animation",
        "poi": "mount-jaw.ghost",
    }
    assert first["enter"]["activates"][0] == {**ghost, "url": f"{folder}/parts/jaw.glb"}
    assert first["exit"]["deactivates"][0] == ghost
    assert first["exit"]["activates"] == [
        {
            "target": "snapfit.bench",
            "type": "action",
            "augmentation": "screw-in-bolt",
            "viewport": "actions",
        }
    ]
    on = {"id": "snapfit.assembly", "mode": "sensor", "key": "state", "operator": "equal"}
    click = {"id": "mount-jaw", "mode": "click", "type": "action", "viewport": "actions"}
    assert first["triggers"] == [
        {**on, "value": "jaw-mounted"},
        {**on, "value": "assembled"},
        click,
    ]
    assert activity["actions"][1]["exit"]["activates"] == []
    (sensor,) = workplace["sensors"]
    assert sensor["url"] == f"{SERVER}/v1/stations/bench-1/assembly"
    base = workplace["things"][0]
    assert base["pois"][1] == {
        "id": "mount-jaw.ghost",
        "x-offset": "0.85",
        "y-offset": "0",
        "z-offset": "0.29",
        **dict.fromkeys(("x-rotation", "y-rotation", "z-rotation"), "0"),
    }


def branching() -> AssetInfo:
    """Left and right can be mounted in either order."""
    info = info_of("hobby-corner-clamp")
    step = info.steps[0]

    def edge(name: str, from_state: str, to_state: str) -> StepInfo:
        return step.model_copy(
            update={"step": name, "from_state": from_state, "to_state": to_state}
        )

    states = [StateInfo(state=name, title="", links=[]) for name in ("none", "l", "r", "both")]
    steps = [
        edge("left-first", "none", "l"),
        edge("right-first", "none", "r"),
        edge("right-last", "l", "both"),
        edge("left-last", "r", "both"),
    ]
    return info.model_copy(update={"states": states, "steps": steps})


def test_where_the_graph_branches_several_actions_follow() -> None:
    workplace, activity = models_of(branching())
    assert_every_reference_is_found(workplace, activity)
    actions = {action["id"]: action for action in activity["actions"]}
    assert activity["start"] == CHOICE
    assert reached_from_start(activity) == set(actions)
    assert actions[CHOICE]["enter"]["removeSelf"] is True
    begun = [each["augmentation"] for each in actions[CHOICE]["enter"]["activates"]]
    assert begun == ["left-first", "right-first"]
    left = actions["left-first"]
    assert [each["augmentation"] for each in left["exit"]["activates"]] == ["right-last"]
    assert left["exit"]["deactivates"][-1]["augmentation"] == "right-first"
    values = [each["value"] for each in left["triggers"] if each["mode"] == "sensor"]
    assert values == ["l", "both"]


def test_an_asset_without_steps_has_no_activity() -> None:
    info = info_of("hobby-corner-clamp").model_copy(update={"steps": []})
    with pytest.raises(NoStepsError, match="has no steps"):
        models_of(info)


def test_what_is_too_long_for_the_standard_is_shortened_and_media_are_shown() -> None:
    info = info_of("hobby-corner-clamp")
    step = info.steps[0]
    note = step.annotations[0].model_copy(update={"text": "x" * 101})
    media = ["/v1/assets/a/media/jaw.mp4", "https://example.com/jaw.jpg?v=1", "/jaw.pdf"]
    changes = {"title": "t" * 200, "text": "y" * 6000, "annotations": [note], "media": media}
    changed = info.model_copy(update={"steps": [step.model_copy(update=changes)]})
    (action,) = models_of(changed)[1]["actions"]
    assert action["instruction"] == {"title": "t" * 99 + "…", "description": "y" * 4999 + "…"}
    _, label, *shown = action["enter"]["activates"]
    assert label["text"] == "x" * 99 + "…"
    assert [(each["augmentation"], each["url"]) for each in shown] == [
        ("video", f"{SERVER}/v1/assets/a/media/jaw.mp4"),
        ("image", "https://example.com/jaw.jpg?v=1"),
    ]


def test_both_are_served_as_files_that_find_each_other(server: Server) -> None:
    answer = server.get(f"{PATH}/activity.json")
    assert answer.headers["content-type"] == "application/json"
    told = answer.headers["content-disposition"]
    assert told == 'attachment; filename="scripted-asset-activity.json"'
    activity = answer.json()
    Activity.model_validate(activity)
    workplace = server.client.get(activity["workplace"]).json()
    Workplace.model_validate(workplace)
    assert_every_reference_is_found(workplace, activity)
    assert server.client.get(activity["id"]).json() == activity
    state = server.client.get(workplace["sensors"][0]["url"]).json()
    assert state["state"] in {"free", "jaw-mounted", "assembled"}
    for detectable in workplace["detectables"][1:]:
        assert server.client.get(detectable["url"]).content.startswith(b"glTF")


def test_station_and_language_are_kept_from_one_to_the_other(server: Server) -> None:
    activity = server.get(f"{PATH}/activity.json?station=bench-1&language=de").json()
    assert activity["language"] == "de"
    workplace = server.client.get(activity["workplace"]).json()
    assert workplace["id"] == activity["workplace"]
    assert workplace["id"].endswith("/workplace.json?station=bench-1&language=de")


@pytest.mark.parametrize("name", ["workplace.json", "activity.json"])
def test_a_wrong_query_is_a_problem(server: Server, name: str) -> None:
    path = f"{PATH}/{name}"
    problem = assert_problem(server.get(f"{path}?station=bench-9"), 404, path)
    assert "bench-1 does" in problem["detail"]
    assert_problem(server.get(f"{path}?language=English"), 422, path)
    assert_problem(server.get(f"{path}?lang=en"), 422, path)
    missing = path.replace("scripted-asset", "another")
    assert_problem(server.get(missing), 404, missing)


def test_a_host_that_is_no_address_is_not_taken_up(server: Server) -> None:
    answer = server.get(f"{PATH}/activity.json", headers={"Host": "evil host/<x>"})
    assert answer.json()["id"] == f"http://127.0.0.1:{server.port}{PATH}/activity.json"
    answer = server.get(f"{PATH}/activity.json", headers={"Host": "bench.local:81"})
    assert answer.json()["id"] == f"http://bench.local:81{PATH}/activity.json"


@pytest.mark.parametrize("name", ["Workplace", "Activity"])
def test_the_document_has_their_schemas(name: str) -> None:
    operation = DOCUMENT["paths"][f"/v1/assets/{{asset}}/arlem/{name.lower()}.json"]["get"]
    content = operation["responses"]["200"]["content"]["application/json"]
    assert content["schema"] == {"$ref": f"#/components/schemas/{name}"}
    assert {"404", "422"} <= set(operation["responses"])
    poi = DOCUMENT["components"]["schemas"]["Poi"]["properties"]
    assert {"x-offset", "z-rotation"} <= set(poi)
