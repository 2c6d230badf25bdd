"""docker/compose.yaml and what it mounts: every name in it leads to something."""

from __future__ import annotations

import json
import os
import re
import sys
from pathlib import Path
from typing import Any

import pytest
import typer
import yaml
from compose_file import (
    COMPOSE,
    DOCKER,
    OVERRIDES,
    dotenv,
    load,
    run,
    services,
    tool,
    variables,
    volumes,
)
from dockerfile import environment, instructions

from snapfit.server.cli.main import app
from snapfit.server.fleet.keepers import MEMORY
from snapfit.server.settings import Settings, load_settings

SERVICES = services()
OURS = {name: it for name, it in SERVICES.items() if "build" in it}
THEIRS = {name: it for name, it in SERVICES.items() if "build" not in it}
REPLICAS = [name for name in SERVICES if name.startswith("api-")]
WORKERS = [name for name in SERVICES if name.startswith("worker-")]
PORT = environment("api")["SNAPFIT_PORT"]


def each(found: dict[str, dict[str, Any]]) -> Any:
    return pytest.mark.parametrize("name", sorted(found))


def compose() -> list[str]:
    """Docker Compose 2, which needs no daemon to read its files."""
    program = tool("docker-compose")
    if not re.search(r"\bv?2\.|\bv?[3-9]\.", run(program, "version", "--short")):
        pytest.skip("docker-compose is older than version 2")
    return [program]


def test_what_starts_by_default_is_one_container() -> None:
    assert dotenv()["COMPOSE_PROFILES"] == "single"
    assert list(services("single")) == ["snapfit"]
    assert (len(REPLICAS), len(WORKERS)) == (2, 3)
    others = {"keys", "valkey", "caddy", "prometheus", "grafana"}
    assert set(services("fleet")) == {*REPLICAS, *WORKERS, *others}


def test_every_variable_is_told_with_its_default() -> None:
    assert dotenv() == {"COMPOSE_PROFILES": "single", **variables()}


@each(SERVICES)
def test_a_service_may_do_and_take_no_more_than_it_needs(name: str) -> None:
    service = SERVICES[name]
    assert service["read_only"] is True
    assert service["cap_drop"] == ["ALL"]
    assert service.get("cap_add", []) == (["NET_BIND_SERVICE"] if name == "caddy" else [])
    assert service["security_opt"] == ["no-new-privileges:true"]
    assert "privileged" not in service
    assert set(service["deploy"]["resources"]["limits"]) == {"cpus", "memory", "pids"}
    assert service["restart"] == ("no" if name == "keys" else "unless-stopped")
    assert service["logging"]["options"]["max-size"]


@each(SERVICES)
def test_what_a_service_mounts_and_joins_exists(name: str) -> None:
    service, document = SERVICES[name], load()
    for source, _ in volumes(service).values():
        if source.startswith("."):
            assert (DOCKER / source).exists(), source
        else:
            assert source in document["volumes"]
    assert set(service.get("networks", [])) <= set(document["networks"])
    ports = service.get("ports", [])
    # Where every network is internal, a published port leads nowhere.
    assert not ports or "default" in service.get("networks", ["default"])


@each(SERVICES)
def test_what_a_service_waits_for_can_happen(name: str) -> None:
    service = SERVICES[name]
    waits = service.get("depends_on", {})
    conditions = waits if isinstance(waits, dict) else {it: {"condition": ""} for it in waits}
    for other, how in conditions.items():
        assert set(service["profiles"]) <= set(SERVICES[other]["profiles"])
        if how["condition"] == "service_healthy":
            own_image = OURS.get(other, {}).get("build", {}).get("target")
            assert "healthcheck" in SERVICES[other] or instructions(own_image, "HEALTHCHECK")
        if how["condition"] == "service_completed_successfully":
            assert SERVICES[other]["restart"] == "no"


@each(THEIRS)
def test_images_of_others_are_pinned(name: str) -> None:
    assert re.fullmatch(r"[\w/]+:v?\d+\.\d+\.\d+(-alpine)?", THEIRS[name]["image"])


@each(OURS)
def test_our_images_are_built_from_here(name: str) -> None:
    build = OURS[name]["build"]
    context = DOCKER / build["context"]
    assert (context / build["dockerfile"]).samefile(DOCKER / "Dockerfile")
    wanted = "worker" if name in {"snapfit", *WORKERS} else "api"
    assert build["target"] == wanted
    assert OURS[name]["image"] == {"worker": "snapfit", "api": "snapfit-api"}[wanted] + ":local"


@each(OURS)
def test_our_services_write_only_where_they_may(name: str) -> None:
    service, image = OURS[name], environment(OURS[name]["build"]["target"])
    places = {place: can for place, (_, can) in volumes(service).items()}
    places |= dict.fromkeys(service["tmpfs"], True)
    assert places["/tmp"]
    assert image["HOME"] == "/tmp"
    if name != "keys":
        assert places[image["SNAPFIT_CACHE"]]
        assert not places["/config"]
    if name in WORKERS:
        assert "/keys" not in places
    else:
        assert places["/keys"] is (name not in REPLICAS)


@each(OURS)
def test_settings_and_command_are_understood(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    service = OURS[name]
    if name == "keys":
        return
    for variable, value in (environment("api") | service["environment"]).items():
        if variable.startswith("SNAPFIT_"):
            monkeypatch.setenv(variable, value)
    command, option, config, *more = service["command"]
    assert option == "--config"
    assert command in getattr(typer.main.get_command(app), "commands", {})
    settings = load_settings(DOCKER / "config" / Path(config).name)
    assert settings.host == "0.0.0.0"
    assert (settings.store == MEMORY) is (name == "snapfit")
    stations = {station.name for station in settings.all_stations}
    if name in WORKERS:
        assert more == ["--station", service["healthcheck"]["test"][-1]]
        assert more[1] in stations
    known = {f"SNAPFIT_{field.upper()}" for field in Settings.model_fields}
    told = {it for it in service["environment"] if it.startswith("SNAPFIT_")}
    assert told <= known


def test_every_station_has_one_worker() -> None:
    stations = [station.name for station in load_settings(DOCKER / "config/fleet.toml").stations]
    assert sorted(SERVICES[name]["command"][-1] for name in WORKERS) == sorted(stations)


def test_services_find_each_other() -> None:
    for name in (*REPLICAS, *WORKERS):
        assert SERVICES[name]["environment"]["SNAPFIT_STORE"] == "redis://valkey:6379/0"
        assert "store" in SERVICES[name]["networks"]
    assert "store" in SERVICES["valkey"]["networks"]
    upstreams = [f"{name}:{PORT}" for name in REPLICAS]
    assert SERVICES["caddy"]["environment"]["SNAPFIT_UPSTREAMS"].split() == upstreams
    scraped = yaml.safe_load((DOCKER / "prometheus/prometheus.yml").read_text("utf-8"))
    (job,) = scraped["scrape_configs"]
    assert job["static_configs"] == [{"targets": upstreams}]
    key = job["authorization"]["credentials_file"]
    assert str(Path(key).parent) in volumes(SERVICES["prometheus"])
    assert key in SERVICES["keys"]["command"][-1]
    path = DOCKER / "grafana/provisioning/datasources/prometheus.yaml"
    (source,) = yaml.safe_load(path.read_text("utf-8"))["datasources"]
    assert source["url"] == "http://prometheus:9090"
    for name in REPLICAS:
        assert {"proxy", "watch"} <= set(SERVICES[name]["networks"])
    assert "proxy" in SERVICES["caddy"]["networks"]
    assert all("watch" in SERVICES[name]["networks"] for name in ("prometheus", "grafana"))


def test_the_api_image_publishes_nothing_past_caddy() -> None:
    published = {name for name, service in services("fleet").items() if "ports" in service}
    assert published == {"caddy", "prometheus", "grafana"}
    for name in ("prometheus", "grafana"):
        assert all(port.startswith("127.0.0.1:") for port in SERVICES[name]["ports"])


def test_the_caddyfile_reads_only_variables_that_it_is_given_or_has_a_default_for() -> None:
    text = (DOCKER / "caddy" / "Caddyfile").read_text("utf-8")
    asked = re.findall(r"\{\$(\w+)(:[^}]*)?\}", text)
    given = SERVICES["caddy"]["environment"]
    assert set(given) <= {name for name, _ in asked}
    assert all(default for _, default in asked)
    assert "flush_interval -1" in text


@pytest.mark.parametrize("path", OVERRIDES, ids=lambda path: path.name)
def test_an_override_changes_services_that_are_there(path: Path) -> None:
    assert set(yaml.safe_load(path.read_text("utf-8"))["services"]) <= set(SERVICES)
    assert path.name in (DOCKER / "README.md").read_text("utf-8")


@pytest.mark.parametrize("path", [COMPOSE, *OVERRIDES], ids=lambda path: path.name)
def test_the_files_follow_the_compose_specification(path: Path) -> None:
    run(tool("check-jsonschema"), "--builtin-schema", "vendor.compose-spec", path)


@pytest.mark.parametrize("profile", ["single", "fleet"])
@pytest.mark.parametrize("override", [None, *OVERRIDES], ids=lambda it: it and it.name)
def test_docker_compose_understands_them(profile: str, override: Path | None) -> None:
    files = ["--file", COMPOSE, *(("--file", override) if override else ())]
    chosen = [] if profile == "single" else ["--profile", profile]
    told = json.loads(run(*compose(), *files, *chosen, "config", "--format", "json"))
    assert set(told["services"]) == set(services(profile))
    for name, service in told["services"].items():
        assert service["read_only"], name


def test_caddy_understands_its_file() -> None:
    caddy = tool("caddy")
    told = json.loads(run(caddy, "adapt", "--config", DOCKER / "caddy/Caddyfile"))
    assert ":443" in told["apps"]["http"]["servers"]["srv0"]["listen"]
    run(caddy, "fmt", "--diff", DOCKER / "caddy/Caddyfile")


def test_prometheus_understands_its_file() -> None:
    path = DOCKER / "prometheus" / "prometheus.yml"
    run(tool("promtool"), "check", "config", "--syntax-only", path)


def test_the_script_that_makes_keys_makes_them_once(tmp_path: Path) -> None:
    """Run as it stands, in other folders."""
    for name in ("keys", "metrics-key", "bin"):
        (tmp_path / name).mkdir()
    snapfit = tmp_path / "bin" / "snapfit"
    main = "from snapfit.server.cli.main import main; main()"
    snapfit.write_text(f'#!/bin/sh\nexec {sys.executable} -c "{main}" "$@"\n')
    snapfit.chmod(0o755)
    shell, options, script = SERVICES["keys"]["command"]
    for place in ("/keys/", "/metrics-key/"):
        script = script.replace(place, f"{tmp_path}{place}")
    keys = tmp_path / "keys" / "keys.json"
    path = f"PATH={snapfit.parent}:{os.environ['PATH']}"
    command = ("env", path, f"SNAPFIT_SECURITY__KEYS_FILE={keys}", shell, options, script)
    first, second = run(*command), run(*command)
    assert len(re.findall(r"^sf_\w+", first, re.MULTILINE)) == 1
    assert second == ""
    roles = {key["name"]: key["role"] for key in json.loads(keys.read_text())["keys"]}
    assert roles == {"first": "operate", "prometheus": "read"}
    assert re.fullmatch(r"sf_\S+\n", (tmp_path / "metrics-key" / "prometheus").read_text())
