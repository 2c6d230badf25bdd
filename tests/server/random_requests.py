"""Random bytes in the place of one parameter of an operation, as raw HTTP: no client corrects it.

The rest of the request is as the document wants it, so that it comes as far as it can.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote_from_bytes, unquote

import numpy as np

# What stands at a parameter that is not under attack, and leads somewhere.
KNOWN = {
    "station": "bench-1",
    "asset": "scripted-asset",
    "part": "jaw",
    "step": "mount-jaw",
    "anchor": "headset-7",
    "name": "jaw.mp4",
}
QUICK = {"timeout_s": "0.01"}
POSE = {"position": [0.1, 0.2, 0.3], "orientation": [0, 0, 0, 1]}
BODIES: dict[str, dict[str, Any]] = {
    "/session": {"key": "x"},
    "/reinitialise": {"parts": ["jaw"]},
    "/assembly/state": {"state": "jaw-mounted"},
    "/anchors/{anchor}": {
        "convention": "unity",
        "board": {"kind": "aruco", "id": 7, "size_m": 0.2},
        "world_from_marker": POSE,
        "ttl_s": 60,
        "restart": True,
    },
}
# Headers that every operation has, documented or not.
HEADERS = (
    *("host", "authorization", "cookie", "origin", "x-request-id", "content-type"),
    *("accept", "range", "content-length", "transfer-encoding", "expect", "upgrade", "forwarded"),
)
# Of which headers are made; some are no address, no range, no key, no event.
HEADER_VALUES = (
    *(b"[", b"http://[", b"//[::1", b"http://\xff:99999", b"a b", b":", b"evil.example", b"%00"),
    *(b"bytes=0-0", b"bytes=9-1", b"bytes=-,", b"Bearer ", b"Bearer \xff", b"Basic Og==", b"*"),
    *(b"100-continue", b"a=b; =; a", b'W/"', b"snapfit-session=\xff", b"1-2", b"a-9" * 30, b""),
    *(
        b"application/json; charset=\xff",
        b"multipart/form-data",
        b"text/plain",
        b"99999999999999999",
    ),
)
FRAMING = ("content-length", "transfer-encoding", "upgrade", "expect")
JSON_VALUES = (
    *(b"null", b"true", b"0", b"-1", b"1e999", b"NaN", b"1" * 400, b"[]", b"{}", b'""'),
    *(b'"\\ud800"', b'"\\u0000"', b'"\xff\xfe"', b'["\\udfff", {}]', b'{"a": ' * 50),
    *(b"[" * 5000, b'{"kind": "charuco", "columns": 1e308}', b"[1, 2, 3, 4]"),
)


@dataclass(frozen=True)
class Operation:
    """An operation of the document."""

    method: str
    path: str
    query: tuple[str, ...]
    headers: tuple[str, ...]
    body: dict[str, Any] | None
    statuses: frozenset[int]

    @property
    def in_path(self) -> list[str]:
        return re.findall(r"{(\w+)}", self.path)

    def slots(self) -> Iterator[tuple[str, str]]:
        """Where bytes can be put: the place, and the parameter's name."""
        yield from (("path", name) for name in self.in_path)
        yield from (("query", name) for name in (*self.query, ""))
        yield from (("header", name) for name in self.headers)
        if self.body is not None:
            yield "body", ""
            yield from (("body", name) for name in self.body)


@dataclass(frozen=True)
class RandomRequest:
    """A request as it goes over the wire.

    Attributes:
        operation: under attack.
        raw: its bytes.
        path: that it asks for, decoded.
        is_http: whether it keeps to the rules for addresses and headers.
        is_framed: whether its headers tell where it ends.
        is_of_operation: whether its path is still one of the operation.
    """

    operation: Operation
    raw: bytes
    path: str
    is_http: bool
    is_framed: bool
    is_of_operation: bool


def operations_of(document: dict[str, Any]) -> list[Operation]:
    """All that the document has."""
    found = []
    for path, methods in document["paths"].items():
        for method, told in methods.items():
            named = {
                place: tuple(it["name"] for it in told.get("parameters", []) if it["in"] == place)
                for place in ("query", "header")
            }
            ending = next((each for each in BODIES if path.endswith(each)), "")
            body = BODIES[ending] if "requestBody" in told else None
            statuses = frozenset(int(each) for each in told["responses"])
            operation = Operation(
                method.upper(), path, named["query"], named["header"], body, statuses
            )
            found.append(operation)
    return found


def random_bytes(rng: np.random.Generator) -> bytes:
    """None to 64 bytes, now and then thousands: any, printable, or of what paths are made."""
    length = int(rng.integers(1500, 6000)) if rng.random() < 0.03 else int(rng.integers(0, 65))
    kind = rng.integers(4)
    if kind == 0:
        return rng.bytes(length)
    if kind == 1:
        return bytes(rng.integers(32, 127, length, dtype=np.uint8))
    if kind == 2:
        return bytes(rng.choice(np.frombuffer(b"./\\%~:;?#[]0\x00aA-\xff", np.uint8), length))
    return bytes(rng.choice(np.frombuffer(b"0123456789+-.eE_ ", np.uint8), length))


def random_body(rng: np.random.Generator, body: dict[str, Any], name: str) -> bytes:
    """Bytes only, or JSON with something else at one member; now and then cut off."""
    if not name:
        return random_bytes(rng)
    value = random_bytes(rng)
    if rng.random() < 0.7:
        value = JSON_VALUES[rng.integers(len(JSON_VALUES))]
    elif rng.random() < 0.5:
        value = json.dumps(value.decode("latin-1")).encode()
    members = {key: json.dumps(each).encode() for key, each in body.items()}
    members[name] = value
    text = b"{" + b", ".join(b'"%s": %s' % (k.encode(), v) for k, v in members.items()) + b"}"
    return text[: rng.integers(len(text))] if rng.random() < 0.1 else text


def random_request(
    operation: Operation, place: str, name: str, rng: np.random.Generator
) -> RandomRequest:
    """The operation with random bytes at one place."""
    attack = random_bytes(rng)
    # As bytes of the address itself, now and then: most of them are no HTTP then.
    is_quoted = rng.random() < 0.85
    sent = quote_from_bytes(attack, safe="").encode() if is_quoted else re.sub(rb"\s", b"", attack)
    values = {each: KNOWN[each].encode() for each in operation.in_path}
    values |= {name: sent} if place == "path" else {}
    path = re.sub(rb"{(\w+)}", lambda it: values[it.group(1).decode()], operation.path.encode())
    query = {key: value for key, value in QUICK.items() if key in operation.query}
    pairs = [f"{key}={value}".encode() for key, value in query.items() if key != name]
    if place == "query":
        pairs.append(b"%s=%s" % (name.encode(), sent) if name else sent)
    target = path + (b"?" + b"&".join(pairs) if pairs else b"")
    headers = {"host": b"127.0.0.1", "connection": b"close"}
    body = None if operation.body is None else json.dumps(operation.body).encode()
    if place == "body" and operation.body is not None:
        body = random_body(rng, operation.body, name)
    if body is not None:
        headers |= {"content-type": b"application/json", "content-length": b"%d" % len(body)}
    if place == "header":
        if rng.random() < 0.3:
            attack = HEADER_VALUES[rng.integers(len(HEADER_VALUES))]
        headers[name] = re.sub(rb"[\r\n]", b"", attack)
    head = b"%s %s HTTP/1.1\r\n" % (operation.method.encode(), target)
    head += b"".join(b"%s: %s\r\n" % (key.encode(), it) for key, it in headers.items())
    # RFC 3986: what an address is made of; RFC 9110: no control character in a header.
    is_http = re.fullmatch(rb"[\w.~!$&'()*+,;=:@/?%-]+", target) is not None and not any(
        re.search(rb"[\x00-\x08\x0a-\x1f\x7f]", value) for value in headers.values()
    )
    is_framed = place != "header" or name not in FRAMING
    decoded = unquote(target.partition(b"?")[0].partition(b"#")[0].decode("latin-1"))
    pattern = re.sub(r"{\w+}", "[^/]+", operation.path)
    return RandomRequest(
        operation,
        head + b"\r\n" + (body or b""),
        decoded,
        is_http,
        is_framed,
        re.fullmatch(pattern, decoded, re.DOTALL) is not None,
    )
