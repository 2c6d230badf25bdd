"""The assembly graph: ways through it, what each step makes, what decides."""

from __future__ import annotations

from dataclasses import replace

import pytest
from toy import link, step, toy

from snapfit.models.asset import Asset, bundled_names, find_asset
from snapfit.models.manifest import State
from snapfit.tracking.assembly.graph import AssemblyGraph


def names(steps: tuple[object, ...]) -> list[str]:
    return [str(getattr(each, "name", each)) for each in steps]


def test_a_branch_joins_again() -> None:
    graph = AssemblyGraph(toy())
    assert graph.start == "free"
    assert graph.root == "board"
    assert graph.successors("free") == ("left-on", "right-on")
    assert graph.predecessors("both") == ("left-on", "right-on")
    assert names(graph.next_steps("right-on")) == ["then-left"]
    assert names(graph.path_to("both")) == ["put-left", "then-right"]
    assert names(graph.path_to("both", ["put-right", "then-left"])) == ["put-right", "then-left"]
    assert graph.path_to("free") == ()


def test_an_edge_knows_its_new_links() -> None:
    graph = AssemblyGraph(toy())
    left, right = graph.edges("free")
    assert [each.child for each in left.new_links] == ["left"]
    assert [each.link.child for each in right.deciding] == ["right"]
    assert [each.link.child for each in graph.coming("left-on")] == ["right"]
    assert [each.link.child for each in graph.held("both")] == ["left", "right"]
    assert graph.later("free") == ()
    assert graph.linked("left-on") == {"board", "left"}
    component = graph.components("left-on")
    assert component["board"] == component["left"] != component["right"]


def test_what_lacks_a_link_depends_on_the_way_taken() -> None:
    graph, left = AssemblyGraph(toy()), link("left")
    assert graph.without_link("both", left, ["put-left", "then-right"]) == "free"
    assert graph.without_link("both", left, ["put-right", "then-left"]) == "right-on"
    assert graph.without_link("left-on", link("right")) == "free"


def chain(asset: Asset) -> Asset:
    states = tuple(state for state in asset.states if state.name != "right-on")
    return replace(asset, states=states, steps=(asset.steps[0], asset.steps[2]))


def test_links_beyond_the_next_state_come_later() -> None:
    graph = AssemblyGraph(chain(toy()))
    assert [each.link.child for each in graph.later("free")] == ["right"]
    (edge, leap) = graph.leaps("free")[0]
    assert edge.to_state == "left-on"
    assert leap.to_state == "both"
    assert names(leap.steps) == ["put-left", "then-right"]


def test_a_step_that_cannot_be_seen_is_taken_with_the_next() -> None:
    asset = chain(toy())
    parts = tuple(replace(part, tracked=part.name != "left") for part in asset.parts)
    (edge,) = AssemblyGraph(replace(asset, parts=parts)).edges("free")
    assert names(edge.steps) == ["put-left", "then-right"]
    assert edge.to_state == "both"


def test_frame_parts_decide_and_connectors_do_not() -> None:
    asset = toy(left={"decides_switch": False})
    both = (link("left", decides_switch=False), link("right"))
    states = (State(name="free"), State(name="both", link=both))
    graph = AssemblyGraph(replace(asset, states=states, steps=(step("put", "free", "both"),)))
    assert [each.link.child for each in graph.edges("free")[0].deciding] == ["right"]
    only = (State(name="free"), State(name="left-on", link=both[:1]))
    graph = AssemblyGraph(replace(asset, states=only, steps=(step("put", "free", "left-on"),)))
    assert [each.link.child for each in graph.edges("free")[0].deciding] == ["left"]


@pytest.mark.parametrize("name", bundled_names())
def test_every_bundled_step_can_be_recognised(name: str) -> None:
    asset = find_asset(name)
    graph = AssemblyGraph(asset)
    for before in asset.steps:
        assert any(edge.steps == (before,) for edge in graph.edges(before.from_state))
    assert names(graph.path_to(asset.states[-1].name)) == [each.name for each in asset.steps]
    assert len(set(graph.components(asset.states[-1].name).values())) == 1
