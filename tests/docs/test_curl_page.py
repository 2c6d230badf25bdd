"""docs/curl.md: every command is run by real curl, and answers in the shape that is printed."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from http import HTTPStatus
from pathlib import Path

import httpx
import pytest
from harness import Server, free_port, running, wait_for
from page_shape import Example, differences, examples, text_differences
from patience import within

from snapfit.server.security.key_file import add_key
from snapfit.server.security.roles import Role

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "curl.md"
DOCUMENT = json.loads((ROOT / "openapi" / "openapi.json").read_text(encoding="utf-8"))
EXAMPLES = examples(PAGE, "sh")
PLAIN = "http://127.0.0.1:8000"
GUARDED = "https://192.168.1.20:8000"
# Names of the simulated bench, and what stands for them in the server that starts in a second.
SCRIPTED = {"hobby-corner-clamp": "scripted-asset", "parts-free": "free"}
LIMIT_S = 60
TRIES = 3
NOT_TRIED = {"/resource", "/v1/assets/{asset}/media/{name}", "/v1/session"}

needs_curl = pytest.mark.skipif(shutil.which("curl") is None, reason="there is no curl")
needs_openssl = pytest.mark.skipif(shutil.which("openssl") is None, reason="there is no openssl")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the commands are run: what one writes, the next reads."""
    return tmp_path_factory.mktemp("curl")


@pytest.fixture(scope="module")
def key(folder: Path, guarded: Server) -> str:
    return (folder / "key").read_text()


@pytest.fixture(scope="module")
def guarded(folder: Path) -> Iterator[Server]:
    """A server with HTTPS that asks for a key."""
    subprocess.run(
        [
            *("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1"),
            *("-subj", "/CN=snapfit", "-addext", "subjectAltName=IP:127.0.0.1"),
            *("-keyout", "tls.key", "-out", "cert.pem"),
        ],
        check=True,
        capture_output=True,
        cwd=folder,
    )
    (folder / "key").write_text(add_key(folder / "keys.json", "headset", Role.READ))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SNAPFIT_SECURITY__KEYS", "on")
        patch.setenv("SNAPFIT_SECURITY__KEYS_FILE", str(folder / "keys.json"))
        patch.setenv("SNAPFIT_SECURITY__TLS_CERT", str(folder / "cert.pem"))
        patch.setenv("SNAPFIT_SECURITY__TLS_KEY", str(folder / "tls.key"))
        with running() as server:
            server.client.close()
            server.client = httpx.Client(
                base_url=f"https://127.0.0.1:{server.port}", verify=False, timeout=30
            )
            wait_for(server.answers, LIMIT_S)
            headers = {"Authorization": f"Bearer {(folder / 'key').read_text()}"}
            wait_for(lambda: server.get("/v1/poses", headers=headers).status_code == 200, LIMIT_S)
            yield server


def run(code: str, folder: Path, **environment: str) -> tuple[str, list[int]]:
    """What the commands write, and the HTTP status of each curl that says nothing of it itself."""
    (folder / ".curlrc").write_text('silent\nwrite-out = "%{stderr}status %{http_code}\\n"\n')
    names = ("PATH", "LANG")
    known = {name: os.environ[name] for name in names if name in os.environ}
    done = subprocess.run(
        ["bash", "-c", code],
        cwd=folder,
        env={**known, "CURL_HOME": str(folder), **environment},
        capture_output=True,
        text=True,
        timeout=within(LIMIT_S),
        check=False,
    )
    return done.stdout, [int(it) for it in re.findall(r"^status (\d+)", done.stderr, re.MULTILINE)]


def check(example: Example, came: str, statuses: list[int]) -> None:
    assert example.answer, f"{PAGE.name}:{example.line} has no answer below it"
    if example.language == "text":
        assert list(text_differences(example.answer, came)) == [], came
        return
    printed = json.loads(example.answer)
    is_problem = isinstance(printed, dict) and "detail" in printed
    assert statuses, "curl had no answer"
    assert statuses[-1] == printed["status"] if is_problem else statuses[-1] // 100 == 2, came
    assert list(differences(printed, json.loads(came))) == [], came


def try_out(example: Example, code: str, folder: Path, **environment: str) -> None:
    """Its commands answer as the page says; of a server that was held up they are asked again."""
    for _ in range(TRIES - 1):
        came, statuses = run(code, folder, **environment)
        is_harmless = "-X" not in code or "sleep" in code  # what listens puts things back
        try:
            check(example, came, statuses)
        except (AssertionError, json.JSONDecodeError):
            if not is_harmless and HTTPStatus.SERVICE_UNAVAILABLE not in statuses:
                raise
            time.sleep(2)
        else:
            return
    check(example, *run(code, folder, **environment))


def addressed(example: Example, server: Server, address: str) -> str:
    scheme = address.partition(":")[0]
    return example.code.replace(address, f"{scheme}://127.0.0.1:{server.port}")


@needs_curl
@pytest.mark.parametrize("example", [it for it in EXAMPLES if PLAIN in it.code], ids=str)
def test_it_answers_as_the_page_says(example: Example, server: Server, folder: Path) -> None:
    wait_for(lambda: server.get("/v1/poses/jaw").json()["pose"]["position"], LIMIT_S)
    code = addressed(example, server, PLAIN)
    for name, scripted in SCRIPTED.items():
        code = code.replace(name, scripted)
    try_out(example, code, folder)


@needs_curl
@needs_openssl
@pytest.mark.parametrize("example", [it for it in EXAMPLES if GUARDED in it.code], ids=str)
def test_keys_and_https(example: Example, guarded: Server, folder: Path, key: str) -> None:
    try_out(example, addressed(example, guarded, GUARDED), folder, SNAPFIT_KEY=key)


def test_every_path_is_tried() -> None:
    code = "".join(it.code for it in EXAMPLES)
    told = set(re.findall(r"https?://[\w.:]+(/[^\s?'\"]*)", code))
    missing = {
        path
        for path in DOCUMENT["paths"]
        if "/stations/{station}/" not in path
        and not any(re.fullmatch(re.sub(r"\\{\w+\\}", "[^/]+", re.escape(path)), it) for it in told)
    }
    assert missing == NOT_TRIED


@pytest.mark.slow
@needs_curl
def test_the_simulated_bench_answers_so_too(folder: Path) -> None:
    """The same page against `snapfit demo`, as a person would try it."""
    port = free_port()
    snapfit = Path(sys.executable).with_name("snapfit")
    demo = subprocess.Popen(
        [snapfit, "demo", "--port", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        wait_for_poses(f"http://127.0.0.1:{port}/v1/poses/jaw")
        for example in EXAMPLES:
            if PLAIN in example.code:
                code = example.code.replace(PLAIN, f"http://127.0.0.1:{port}")
                try_out(example, code, folder)
    finally:
        demo.send_signal(signal.SIGTERM)
        demo.wait(LIMIT_S)


def wait_for_poses(url: str) -> None:
    give_up_at_s = time.monotonic() + 600
    while time.monotonic() < give_up_at_s:
        try:
            if httpx.get(url).json().get("pose", {}).get("position"):
                return
        except httpx.TransportError:
            pass
        time.sleep(1)
    raise AssertionError("the demo has found no jaw within 10 minutes")


@pytest.mark.parametrize(
    ("printed", "came", "said"),
    [
        ({"a": 1}, {"a": "1"}, "answer.a is '1', printed 1"),
        ({"a": 1}, {"a": 1, "b": 2}, "answer.b is not printed"),
        ({"a": 1, "...": ""}, {"b": 2}, "answer.a did not come"),
        ({"a": [1, 2, 3]}, {"a": [1, 2]}, "answer.a has 2 numbers, printed 3"),
        ([{"a": True}, "..."], [{"a": 1}], "answer[0].a is 1, printed True"),
        ({"status": 404, "detail": ""}, {"status": 403, "detail": ""}, "answer.status is 403"),
        (["x"], [], "answer is empty"),
    ],
)
def test_what_differs_is_noticed(printed: object, came: object, said: str) -> None:
    (difference,) = differences(printed, came)
    assert said in difference


@pytest.mark.parametrize(
    ("printed", "came", "is_the_same"),
    [
        ("HTTP/1.1 304 Not Modified", "HTTP/1.1 304 Not Modified", True),
        ("HTTP/1.1 304 Not Modified", "HTTP/1.1 200 OK", False),
        ("200 image/jpeg 91034", "200 image/jpeg 1234", True),
        ("200 image/jpeg 91034", "404 image/jpeg 1234", False),
        ('data: {"seq": 1}', 'data: {"seq":2}', True),
        ('data: {"seq": 1}', 'data: {"seq":"x"}', False),
        ('etag: W/"06acbce73e4c-a2-99-fresh"', 'etag: W/"7a4bae3fad3d-a1-90-fresh"', True),
        ("glTF", "glTX", False),
    ],
)
def test_lines_are_compared_but_for_numbers(printed: str, came: str, is_the_same: bool) -> None:
    assert (list(text_differences(printed, f"before\n{came}\nafter")) == []) is is_the_same
