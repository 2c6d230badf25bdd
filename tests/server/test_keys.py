"""API keys at rest: hashed, in a file that nobody else reads."""

from __future__ import annotations

import asyncio
import json
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from snapfit.server.errors import KeyFileError
from snapfit.server.security.first_key import FIRST_KEY_NAME, first_key
from snapfit.server.security.key_file import add_key, read_keys, remove_key
from snapfit.server.security.key_hash import hash_key, id_of, is_key, new_key
from snapfit.server.security.key_ring import KeyRing
from snapfit.server.security.rate_limit import TokenBuckets
from snapfit.server.security.roles import Role
from snapfit.server.security.session import SESSION_S, session_key_id, sign_session
from snapfit.server.security.settings import SecuritySettings, keys_needed

SNAPFIT = str(Path(sys.executable).with_name("snapfit"))


def test_a_key_is_known_by_its_hash_alone() -> None:
    key, other = new_key(), new_key()
    assert key != other
    stored = hash_key(key)
    assert key not in stored
    assert key.rpartition("_")[2] not in stored
    assert is_key(key, stored)
    assert not is_key(other, stored)
    assert stored != hash_key(key), "every hash has a salt of its own"


@pytest.mark.parametrize(
    "text", ["", "sf_", "sf_12345678_short", "x" * 55, pytest.param(new_key() + "\n", id="line")]
)
def test_what_is_no_key_has_no_id(text: str) -> None:
    assert id_of(text) is None


def test_the_file_has_no_key_and_one_reader(tmp_path: Path) -> None:
    path = tmp_path / "new" / "keys.json"
    key = add_key(path, "headset 1", Role.READ)
    assert key not in path.read_text()
    assert key.split("_", 2)[2] not in path.read_text()
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    table = read_keys(path)
    assert table is not None
    assert [(one.name, one.role, one.id) for one in table.keys] == [
        ("headset 1", Role.READ, id_of(key))
    ]


def test_names_are_unique_and_removed_by_name_or_id(tmp_path: Path) -> None:
    path = tmp_path / "keys.json"
    key = add_key(path, "one", Role.READ)
    add_key(path, "two", Role.OPERATE)
    with pytest.raises(KeyFileError, match="has a key named 'one' already"):
        add_key(path, "one", Role.READ)
    with pytest.raises(KeyFileError, match="'a/b' is no name"):
        add_key(path, "a/b", Role.READ)
    with pytest.raises(KeyFileError, match="has no key 'three'; it has one, two"):
        remove_key(path, "three")
    remove_key(path, id_of(key) or "")
    remove_key(path, "two")
    table = read_keys(path)
    assert table is not None
    assert table.keys == ()


@pytest.mark.parametrize("text", ["", "{", '{"keys": [{"id": "x"}]}', '{"version": 2}'])
def test_a_damaged_file_is_refused_without_its_contents(tmp_path: Path, text: str) -> None:
    path = tmp_path / "keys.json"
    path.write_text(text)
    with pytest.raises(KeyFileError, match="is no key file") as caught:
        read_keys(path)
    assert str(path) in str(caught.value)


def test_a_ring_knows_keys_and_notices_what_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("snapfit.server.security.key_ring._LOOK_PERIOD_S", 0.0)
    path = tmp_path / "keys.json"
    key = add_key(path, "one", Role.READ)
    ring = KeyRing(path)

    async def name(of: str) -> str | None:
        record = await ring.of_key(of)
        return None if record is None else record.name

    assert ring.remembered(key) is None
    assert asyncio.run(name(key)) == "one"
    record = ring.remembered(key)
    assert record is not None
    session = ring.new_session(record)
    assert ring.of_session(session) == record
    forged = f"sf_{id_of(key)}_{new_key().split('_', 2)[2]}"
    assert asyncio.run(name(forged)) is None
    second = add_key(path, "two", Role.OPERATE)
    assert asyncio.run(name(second)) == "two"
    remove_key(path, "one")
    assert asyncio.run(name(key)) is None
    assert ring.of_session(session) is None
    assert not ring.holds(record)
    path.write_text("{")
    assert asyncio.run(name(second)) == "two", "a damaged file locks nobody out"
    path.unlink()
    assert asyncio.run(name(second)) is None


def test_a_session_is_signed_and_ends() -> None:
    secret = "ab" * 32
    token = sign_session(secret, "12345678", 1000)
    assert session_key_id(secret, token, 1000 + SESSION_S - 1) == "12345678"
    assert session_key_id(secret, token, 1000 + SESSION_S) is None
    assert session_key_id("cd" * 32, token, 1000) is None
    for wrong in ("", "x", token[:-1], token.replace("12345678", "87654321"), "ä.1." + token):
        assert session_key_id(secret, wrong, 1000) is None


def test_a_bucket_gives_a_rate_and_a_burst() -> None:
    now_s = 0.0
    buckets = TokenBuckets(rate_per_s=10, burst=3, clock_s=lambda: now_s)
    assert [buckets.take("a") for _ in range(3)] == [0, 0, 0]
    assert buckets.take("a") == pytest.approx(0.1)
    assert buckets.take("b") == 0
    now_s = 0.05
    assert buckets.take("a") == pytest.approx(0.05)
    now_s = 0.1
    assert buckets.take("a") == 0
    now_s = 100.0
    assert [buckets.take("a") for _ in range(3)] == [0, 0, 0]
    assert buckets.take("a") > 0


def test_buckets_of_many_clients_take_no_more_memory() -> None:
    buckets = TokenBuckets(1, 1)
    for number in range(20_000):
        buckets.take(str(number))
    assert len(buckets._buckets) == 10_000


@pytest.mark.parametrize(
    ("host", "needed"),
    [
        ("127.0.0.1", False),
        ("127.3.2.1", False),
        ("::1", False),
        ("localhost", False),
        ("0.0.0.0", True),
        ("::", True),
        ("192.168.1.5", True),
        ("bench-pc", True),
    ],
)
def test_keys_are_needed_where_others_can_ask(host: str, needed: bool) -> None:
    assert keys_needed(SecuritySettings(), host) is needed
    assert keys_needed(SecuritySettings(keys="on"), host)
    assert not keys_needed(SecuritySettings(keys="off"), host)


def test_the_first_key_is_made_once(tmp_path: Path) -> None:
    path = tmp_path / "keys.json"
    security = SecuritySettings(keys_file=str(path))
    assert first_key(security, "127.0.0.1") is None
    assert not path.exists()
    key = first_key(security, "0.0.0.0")
    table = read_keys(path)
    assert key is not None
    assert table is not None
    assert [(one.name, one.role) for one in table.keys] == [(FIRST_KEY_NAME, Role.OPERATE)]
    assert is_key(key, table.keys[0].hash)
    assert first_key(security, "0.0.0.0") is None


def snapfit(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [SNAPFIT, *arguments], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )


def test_keys_on_the_command_line(tmp_path: Path) -> None:
    (tmp_path / "snapfit.toml").write_text('[security]\nkeys_file = "own.json"\n')
    assert f"no keys in {tmp_path / 'own.json'}" in snapfit(tmp_path, "key", "list").stdout
    added = snapfit(tmp_path, "key", "add", "tablet", "--role", "operate")
    assert added.returncode == 0
    key = added.stdout.strip()
    stored = json.loads((tmp_path / "own.json").read_text())["keys"][0]
    assert stored["id"] == id_of(key)
    listed = snapfit(tmp_path, "key", "list")
    assert {"tablet", id_of(key), "operate"} <= set(listed.stdout.split())
    assert key not in listed.stdout
    assert snapfit(tmp_path, "key", "remove", "tablet").returncode == 0
    wrong = snapfit(tmp_path, "key", "remove", "tablet")
    assert (wrong.returncode, wrong.stderr.count("\n")) == (2, 1)
    assert "has no key 'tablet'" in wrong.stderr


def test_a_first_start_shows_key_address_and_code_once(tmp_path: Path) -> None:
    (tmp_path / "snapfit.toml").write_text(
        '[station]\nsource = "nowhere"\n[security]\nkeys = "on"\nkeys_file = "keys.json"\n'
    )
    port = "18777"
    first = snapfit(tmp_path, "serve", "--port", port)
    key = next(word for word in first.stdout.split() if word.startswith("sf_"))
    assert f"http://127.0.0.1:{port}/?key={key}" in first.stdout.split()
    assert first.stdout.count("█") > 50
    assert key not in first.stderr
    again = snapfit(tmp_path, "serve", "--port", port)
    assert "sf_" not in again.stdout + again.stderr
