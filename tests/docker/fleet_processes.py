"""The profile `fleet` as processes on loopback, from the commands and variables of compose.yaml.

What a network of containers gives is put in by hand: each service's name becomes an address with a
port of its own, each volume a folder. Redis stands in for Valkey, and one worker for the three. It
starts from the demo's own first poses, since on a busy machine finding the parts takes minutes.
"""

from __future__ import annotations

import os
import re
import shutil
import ssl
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
from compose_file import DOCKER, services
from dockerfile import environment
from harness import free_port, wait_for

REPLICAS = ("api-1", "api-2")
_MAIN = "from snapfit.server.cli.main import main; main()"
_START_LIMIT_S = 60
# Compiles kernels and renders the demo, if nobody on this machine did so before.
FIRST_POSES_LIMIT_S = 400


class FleetProcesses:
    """All of it.

    Args:
        folder: for what the volumes hold.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._services = services("fleet")
        names = ("valkey", *REPLICAS, "http", "https", "prometheus")
        self.ports = {name: free_port() for name in names}
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        for name in ("keys", "metrics-key", "caddy", "prometheus", "logs", "bin", "config"):
            (folder / name).mkdir()
        config = (DOCKER / "config/fleet.toml").read_text("utf-8")
        config = config.replace('source = "demo"', 'source = "demo"\ndetector = "none"')
        (folder / "config/fleet.toml").write_text(config, encoding="utf-8")
        snapfit = folder / "bin" / "snapfit"
        snapfit.write_text(f'#!/bin/sh\nexec {sys.executable} -c "{_MAIN}" "$@"\n')
        snapfit.chmod(0o755)

    def start(self) -> None:
        """In the order that `depends_on` asks for, but for Caddy's wait."""
        self._run("valkey", ["redis-server", *self._valkey_options()], {})
        self.key = self._make_keys()
        for name in (*REPLICAS, "worker-1"):
            self._run(name, self._command(name), self._variables(name))
        self._run(
            "caddy", ["caddy", "run", "--config", str(DOCKER / "caddy/Caddyfile")], self._caddy()
        )
        self._run("prometheus", self._prometheus(), {})
        wait_for(self.certificate.is_file, _START_LIMIT_S)
        wait_for(lambda: self._answers("https"), _START_LIMIT_S)

    def end(self) -> None:
        for process in self.processes.values():
            process.terminate()
        for process in self.processes.values():
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait(5)

    @property
    def certificate(self) -> Path:
        """Of Caddy's own authority."""
        return self._folder / "caddy/data/caddy/pki/authorities/local/root.crt"

    def client(self, *, with_key: bool = True) -> httpx.Client:
        """One that trusts that authority, at Caddy."""
        headers = {"Authorization": f"Bearer {self.key}"} if with_key else {}
        context = ssl.create_default_context(cafile=str(self.certificate))
        base_url = f"https://localhost:{self.ports['https']}"
        return httpx.Client(base_url=base_url, verify=context, headers=headers, timeout=20)

    def at(self, name: str, path: str) -> httpx.Response:
        """What a replica or Prometheus answers, past Caddy."""
        headers = {"Authorization": f"Bearer {self.key}"}
        return httpx.get(f"http://127.0.0.1:{self.ports[name]}{path}", headers=headers, timeout=20)

    def log(self, name: str) -> str:
        return (self._folder / "logs" / name).read_text("utf-8", "replace")

    def _answers(self, name: str) -> bool:
        try:
            if name == "https":
                with self.client(with_key=False) as client:
                    return client.get("/healthz").status_code == 200
            return self.at(name, "/healthz").status_code == 200
        except httpx.TransportError:
            return False

    def _run(self, name: str, command: list[str], more: dict[str, str]) -> None:
        path = f"{self._folder / 'bin'}:{os.environ['PATH']}"
        with (self._folder / "logs" / name).open("wb") as log:
            self.processes[name] = subprocess.Popen(
                command,
                env={**os.environ, "PATH": path, **more},
                stdout=log,
                stderr=subprocess.STDOUT,
                cwd=self._folder,
            )

    def _command(self, name: str) -> list[str]:
        words: list[str] = self._services[name]["command"]
        return ["snapfit", *(word.replace("/config/", f"{self._folder}/config/") for word in words)]

    def _variables(self, name: str) -> dict[str, str]:
        """The image's and the service's, at this machine's loopback addresses."""
        target = self._services[name]["build"]["target"]
        found = {**environment(target), **self._services[name].get("environment", {})}
        for unwanted in ("PATH", "HOME", "SNAPFIT_CACHE"):
            found.pop(unwanted)
        found["SNAPFIT_SECURITY__KEYS_FILE"] = str(self._folder / "keys/keys.json")
        # At 0.0.0.0 keys are needed; here nobody else may reach it.
        found |= {"SNAPFIT_HOST": "127.0.0.1", "SNAPFIT_SECURITY__KEYS": "on"}
        found["SNAPFIT_PORT"] = str(self.ports.get(name, 1))
        return {name: self._here(value) for name, value in found.items()}

    def _here(self, text: str) -> str:
        """A text with services' addresses, at loopback."""
        for name in ("valkey", *REPLICAS):
            text = re.sub(rf"\b{name}:\d+", f"127.0.0.1:{self.ports[name]}", text)
        return text

    def _valkey_options(self) -> list[str]:
        options: list[str] = self._services["valkey"]["command"][1:]
        return [*options, "--bind", "127.0.0.1", "--port", str(self.ports["valkey"])]

    def _make_keys(self) -> str:
        """Run the service `keys`; the key that it shows."""
        shell, options, script = self._services["keys"]["command"]
        for place in ("/keys/", "/metrics-key/"):
            script = script.replace(place, f"{self._folder}{place}")
        self._run("make-keys", [shell, options, script], self._variables("keys"))
        assert self.processes.pop("make-keys").wait(_START_LIMIT_S * 2) == 0, self.log("make-keys")
        return re.findall(r"^sf_\S+", self.log("make-keys"), re.MULTILINE)[0]

    def _caddy(self) -> dict[str, str]:
        given: dict[str, str] = self._services["caddy"]["environment"]
        return {
            **{name: self._here(value) for name, value in given.items()},
            "SNAPFIT_HTTP_PORT": str(self.ports["http"]),
            "SNAPFIT_HTTPS_PORT": str(self.ports["https"]),
            "XDG_DATA_HOME": str(self._folder / "caddy/data"),
            "XDG_CONFIG_HOME": str(self._folder / "caddy/config"),
        }

    def _prometheus(self) -> list[str]:
        config = self._folder / "prometheus.yml"
        text = (DOCKER / "prometheus/prometheus.yml").read_text("utf-8")
        text = text.replace("/metrics-key/", f"{self._folder}/metrics-key/")
        config.write_text(self._here(text), encoding="utf-8")
        return [
            "prometheus",
            f"--config.file={config}",
            f"--storage.tsdb.path={self._folder / 'prometheus'}",
            f"--web.listen-address=127.0.0.1:{self.ports['prometheus']}",
        ]


def missing() -> list[str]:
    """The programs that this needs and this machine has not."""
    return [name for name in ("redis-server", "caddy", "prometheus") if not shutil.which(name)]


@contextmanager
def fleet(folder: Path) -> Iterator[FleetProcesses]:
    it = FleetProcesses(folder)
    try:
        it.start()
        yield it
    finally:
        it.end()
