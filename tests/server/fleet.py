"""A redis-server of our own, worker machines and replicas for tests of several machines."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from harness import HERE, Said, Server, free_port, wait_for, wait_or_kill, with_tests
from patience import within

from snapfit.models.cache import CACHE_VARIABLE

REDIS = shutil.which("redis-server") or shutil.which("valkey-server")
needs_redis = pytest.mark.skipif(REDIS is None, reason="there is no redis-server to test with")


class Redis:
    """A redis-server on loopback that can be stopped, hung and started again; keeps nothing."""

    def __init__(self) -> None:
        self.port = free_port()
        self.url = f"redis://127.0.0.1:{self.port}/0"
        self.process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        assert REDIS is not None
        options = ("--bind", "127.0.0.1", "--save", "", "--appendonly", "no")
        self.process = subprocess.Popen(
            [REDIS, "--port", str(self.port), *options], stdout=subprocess.DEVNULL
        )

    def answers(self) -> bool:
        try:
            with socket.create_connection(("127.0.0.1", self.port), timeout=1) as wire:
                wire.sendall(b"PING\r\n")
                return wire.recv(16).startswith(b"+PONG")
        except OSError:
            return False

    def stop(self) -> None:
        if self.process is not None:
            self.process.send_signal(signal.SIGCONT)
            self.process.terminate()
            self.process.wait(within(30))
            self.process = None

    def signal(self, number: int) -> None:
        assert self.process is not None
        self.process.send_signal(number)


@contextmanager
def redis_server() -> Iterator[Redis]:
    it = Redis()
    it.start()
    try:
        wait_for(it.answers)
        yield it
    finally:
        it.stop()


class WorkerMachine:
    """`snapfit worker` with the scripted pipeline."""

    def __init__(self, folder: Path, url: str, **environment: str) -> None:
        config = folder / "worker.toml"
        config.write_text(f'store = "{url}"\n')
        self.said = Said()
        self.process = subprocess.Popen(
            [sys.executable, str(HERE / "work_scripted.py"), str(config)],
            env={**os.environ, "PYTHONPATH": with_tests(), **environment},
            stdout=self.said.out,
            stderr=self.said.err,
        )

    def end(self, number: int = signal.SIGTERM) -> tuple[int, str, str]:
        """Exit code, standard output, standard error."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        wait_or_kill(self.process)
        return self.process.returncode, *self.said.read()


@contextmanager
def working(folder: Path, url: str, **environment: str) -> Iterator[WorkerMachine]:
    machine = WorkerMachine(folder, url, **environment)
    try:
        yield machine
    finally:
        machine.end()
        machine.said.close()


@contextmanager
def replica(url: str, cache: Path | None = None) -> Iterator[Server]:
    """An API without workers of its own, on a machine with a cache of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SNAPFIT_STORE", url)
        if cache is not None:
            patch.setenv(CACHE_VARIABLE, str(cache))
        server = Server()
    try:
        wait_for(server.answers, 30)
        yield server
    finally:
        server.end()


@dataclass
class Fleet:
    """A worker's machine, whose camera sees a marker, and two replicas; each has its own cache."""

    redis: Redis
    machine: WorkerMachine
    servers: tuple[Server, Server]
    folder: Path


@contextmanager
def a_fleet(folder: Path) -> Iterator[Fleet]:
    own = {"SCRIPTED_FAULT": "marker", CACHE_VARIABLE: str(folder / "worker")}
    with ExitStack() as open_now:
        redis = open_now.enter_context(redis_server())
        machine = open_now.enter_context(working(folder, redis.url, **own))
        one = open_now.enter_context(replica(redis.url, folder / "one"))
        two = open_now.enter_context(replica(redis.url, folder / "two"))
        for server in (one, two):
            wait_for(lambda server=server: is_fresh(server))
        yield Fleet(redis, machine, (one, two), folder)


def is_fresh(server: Server) -> bool:
    answer = server.get("/v1/poses")
    return answer.status_code == 200 and not answer.json()["stale"]
