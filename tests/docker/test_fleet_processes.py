"""The fleet of compose.yaml as processes: HTTPS, balance, streams, failover, metrics."""

from __future__ import annotations

import asyncio
import json
import re
import ssl
import time
from collections.abc import Iterator

import httpx
import pytest
import websockets
from compose_file import DOCKER
from fleet_processes import FIRST_POSES_LIMIT_S, REPLICAS, FleetProcesses, fleet, missing
from harness import wait_for
from prometheus_client.parser import text_string_to_metric_families

STATION = "/v1/stations/bench-1"
FOUND_LIMIT_S = 180

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(missing()), reason=f"there is no {', '.join(missing())}"),
]


@pytest.fixture(scope="module")
def it(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FleetProcesses]:
    """The fleet, when it has its first poses."""
    with fleet(tmp_path_factory.mktemp("fleet")) as found:
        with found.client() as client:
            try:
                wait_for(lambda: is_fresh(client), FIRST_POSES_LIMIT_S)
            except AssertionError:
                logs = "\n".join(f"{name}: {found.log(name)[-1500:]}" for name in found.processes)
                pytest.fail(f"no first poses\n{logs}")
        yield found


def is_fresh(client: httpx.Client) -> bool:
    answer = client.get(f"{STATION}/poses")
    return answer.status_code == 200 and not answer.json()["stale"]


def answered(found: FleetProcesses, replica: str) -> float:
    """How many requests for poses a replica has answered."""
    families = text_string_to_metric_families(found.at(replica, "/metrics").text)
    samples = [sample for family in families for sample in family.samples]
    return sum(
        sample.value
        for sample in samples
        if sample.name == "snapfit_request_seconds_count" and "poses" in sample.labels["route"]
    )


def test_https_is_caddys_own_and_http_leads_there(it: FleetProcesses) -> None:
    with it.client(with_key=False) as client:
        answer = client.get(f"{STATION}/poses")
        assert answer.status_code == 401
        assert answer.json()["type"].endswith("key-needed")
    answer = httpx.get(f"http://localhost:{it.ports['http']}/v1/poses")
    assert answer.status_code == 308
    assert answer.headers["location"] == "https://localhost/v1/poses"
    with pytest.raises(httpx.ConnectError, match="CERTIFICATE_VERIFY_FAILED"):
        httpx.get(f"https://localhost:{it.ports['https']}/healthz")


def test_parts_are_tracked_through_all_of_it(it: FleetProcesses) -> None:
    seen: set[str] = set()

    def is_tracked() -> bool:
        seen.update(part["status"] for part in client.get(f"{STATION}/poses").json()["parts"])
        return "tracked" in seen

    with it.client() as client:
        try:
            wait_for(is_tracked, FOUND_LIMIT_S)
        except AssertionError:
            pytest.fail(f"parts are {seen}: {client.get(STATION).json()['worker']}")
    assert seen <= {"tracked", "inferred", "predicted", "searching", "lost"}


def test_a_session_knows_that_it_came_by_https(it: FleetProcesses) -> None:
    with it.client(with_key=False) as client:
        origin = str(client.base_url).rstrip("/")
        answer = client.post("/v1/session", json={"key": it.key}, headers={"Origin": origin})
        assert answer.is_success, answer.text
        assert "secure" in answer.headers["set-cookie"].lower()
        assert client.get(f"{STATION}/poses").status_code == 200


def test_both_replicas_answer(it: FleetProcesses) -> None:
    before = {name: answered(it, name) for name in REPLICAS}
    with it.client() as client:
        statuses = {client.get(f"{STATION}/poses").status_code for _ in range(60)}
    assert statuses == {200}
    shares = {name: answered(it, name) - before[name] for name in REPLICAS}
    assert sum(shares.values()) >= 60
    assert min(shares.values()) >= 12, shares


def test_events_come_through_at_once(it: FleetProcesses) -> None:
    with it.client() as client, client.stream("GET", f"{STATION}/events") as answer:
        assert answer.headers["content-type"] == "text/event-stream"
        begin_s = time.monotonic()
        lines = answer.iter_lines()
        assert next(lines) == "retry: 1000"
        # The stream goes on: nobody waited for its end.
        assert time.monotonic() - begin_s < 2
        later = (line for line in lines if line)
        assert re.match(r"(:|id:|event:)", next(later))
        assert time.monotonic() - begin_s < 15


def test_every_snapshot_comes_through_a_web_socket(it: FleetProcesses) -> None:
    async def read() -> list[int]:
        context = ssl.create_default_context(cafile=str(it.certificate))
        url = f"wss://localhost:{it.ports['https']}{STATION}/stream"
        headers = {"Authorization": f"Bearer {it.key}"}
        async with websockets.connect(url, ssl=context, additional_headers=headers) as socket:
            return [json.loads(await asyncio.wait_for(socket.recv(), 10))["seq"] for _ in range(5)]

    numbers = asyncio.run(read())
    assert numbers == sorted(set(numbers))


def test_pictures_come_through_one_by_one(it: FleetProcesses) -> None:
    with it.client() as client, client.stream("GET", f"{STATION}/overlay.mjpeg") as answer:
        assert answer.status_code == 200
        seen = b""
        for chunk in answer.iter_bytes():
            seen += chunk
            if seen.count(b"\xff\xd8\xff") >= 3:
                return
    pytest.fail(f"the stream ended after {len(seen)} bytes")


def test_prometheus_has_an_answer_for_every_panel(it: FleetProcesses) -> None:
    dashboard = json.loads((DOCKER / "grafana/dashboards/snapfit.json").read_text("utf-8"))
    targets = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]

    def unanswered() -> set[str]:
        return {expression for expression in targets if not ask(it, expression)}

    def all_are_answered() -> bool:
        time.sleep(1)
        return not unanswered()

    wait_for(lambda: len(ask(it, "up == 1")) == len(REPLICAS), 60)
    try:
        wait_for(all_are_answered, 60)
    except AssertionError:
        pytest.fail(f"no answer for {unanswered()}")


def ask(found: FleetProcesses, expression: str) -> list[object]:
    fillings = {"$station": ".*", "$__rate_interval": "1m", "$__range": "15m"}
    for variable, value in fillings.items():
        expression = expression.replace(variable, value)
    url = f"http://127.0.0.1:{found.ports['prometheus']}/api/v1/query"
    try:
        answer = httpx.get(url, params={"query": expression}, timeout=20)
    except httpx.TransportError:  # not started yet
        return []
    result: list[object] = answer.json()["data"]["result"] if answer.is_success else []
    return result


def test_a_replica_that_dies_is_not_missed(it: FleetProcesses) -> None:
    """The last one: it takes a replica away."""
    victim = it.processes["api-1"]
    with it.client() as client:
        victim.kill()
        victim.wait(5)
        statuses = [client.get(f"{STATION}/poses").status_code for _ in range(40)]
    assert set(statuses) == {200}
