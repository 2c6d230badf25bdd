"""Grafana's dashboard asks for nothing that /metrics does not tell."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml
from harness import Server, wait_for
from prometheus_client.parser import text_string_to_metric_families

DASHBOARD = json.loads(
    (Path(__file__).parents[2] / "docker/grafana/dashboards/snapfit.json").read_text("utf-8")
)
PANELS: list[dict[str, Any]] = DASHBOARD["panels"]
# What Prometheus itself adds.
SCRAPED = {"instance", "job", "le"}
PROMTOOL = shutil.which("promtool")


def filled(expression: str) -> str:
    """An expression as Grafana sends it."""
    fillings = {"$station": ".*", "$__rate_interval": "1m", "$__range": "15m"}
    for variable, value in fillings.items():
        expression = expression.replace(variable, value)
    return expression


def expressions() -> list[str]:
    return [target["expr"] for panel in PANELS for target in panel["targets"]]


def told(server: Server) -> dict[str, set[str]]:
    """The names of all samples, each with its labels."""
    found: dict[str, set[str]] = {}
    for family in text_string_to_metric_families(server.get("/metrics").text):
        for sample in family.samples:
            found.setdefault(sample.name, set()).update(sample.labels)
    return found


def test_every_metric_and_label_is_told(server: Server) -> None:
    server.get("/v1/poses")
    live = wait_for(lambda: (it := told(server)).get("snapfit_frame_seconds") and it)
    for panel in PANELS:
        for target in panel["targets"]:
            names = set(re.findall(r"snapfit_\w+", target["expr"]))
            assert names, panel["title"]
            assert names <= set(live), panel["title"]
            labels = {word for name in names for word in live[name]} | SCRAPED
            grouped = re.findall(r"by \(([^)]*)\)", target["expr"])
            wanted = {word.strip() for group in grouped for word in group.split(",")}
            wanted |= set(re.findall(r"\{\{(\w+)\}\}", target["legendFormat"]))
            assert wanted <= labels, panel["title"]


def test_every_metric_of_ours_is_shown(server: Server) -> None:
    server.get("/v1/poses")
    live = wait_for(lambda: (it := told(server)).get("snapfit_frame_seconds") and it)
    shown = set(re.findall(r"snapfit_\w+", " ".join(expressions())))
    bare = {re.sub(r"_(sum|count|bucket|created)$", "", name) for name in live}
    assert bare - {re.sub(r"_(sum|count|bucket)$", "", name) for name in shown} <= {
        "snapfit_dropped_clients"  # its time of creation
    }


def test_panels_do_not_overlap_and_use_the_data_source_that_is_there() -> None:
    path = Path(__file__).parents[2] / "docker/grafana/provisioning/datasources/prometheus.yaml"
    (source,) = yaml.safe_load(path.read_text("utf-8"))["datasources"]
    taken: set[tuple[int, int]] = set()
    for panel in PANELS:
        place = panel["gridPos"]
        columns = range(place["x"], place["x"] + place["w"])
        cells = {(x, y) for x in columns for y in range(place["y"], place["y"] + place["h"])}
        assert max(columns) < 24
        assert not cells & taken, panel["title"]
        taken |= cells
        assert panel["datasource"] == {"type": source["type"], "uid": source["uid"]}
    assert len({panel["id"] for panel in PANELS}) == len(PANELS)


@pytest.mark.skipif(PROMTOOL is None, reason="there is no promtool: .ci/run installs prometheus")
def test_prometheus_understands_every_expression(tmp_path: Path) -> None:
    rules = [{"record": f"it:{i}", "expr": filled(it)} for i, it in enumerate(expressions())]
    path = tmp_path / "rules.yaml"
    path.write_text(yaml.safe_dump({"groups": [{"name": "dashboard", "rules": rules}]}))
    done = subprocess.run(
        [str(PROMTOOL), "check", "rules", str(path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert f"{len(rules)} rules found" in done.stdout
