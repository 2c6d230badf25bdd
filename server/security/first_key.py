"""The first key of a server that others can reach: made at its first start, shown once."""

from __future__ import annotations

import io
import socket
from pathlib import Path
from urllib.parse import urlencode

from rich.console import Console

from snapfit.server.security.key_file import add_key, default_key_file, read_keys
from snapfit.server.security.roles import Role
from snapfit.server.security.settings import SecuritySettings, keys_needed

FIRST_KEY_NAME = "first"
_ANY_HOST = ("0.0.0.0", "::", "")  # noqa: S104
# Of the block for documentation (RFC 5737): only the way there is asked for, nothing is sent.
_SOMEWHERE = ("192.0.2.1", 9)


def key_file(security: SecuritySettings) -> Path:
    """The file that the settings name, or the usual one."""
    given = security.keys_file
    return default_key_file() if given is None else Path(given).absolute()


def first_key(security: SecuritySettings, host: str) -> str | None:
    """A new key that may operate, if keys are needed and there is none yet.

    Raises:
        KeyFileError: the key file cannot be read or written.
    """
    path = key_file(security)
    if not keys_needed(security, host):
        return None
    table = read_keys(path)
    if table is not None and table.keys:
        return None
    return add_key(path, FIRST_KEY_NAME, Role.OPERATE)


def show_first_key(console: Console, key: str, base_url: str, path: Path) -> None:
    """Print a key once: its URL, the same as a QR code, and where its hash is kept."""
    import segno  # for this one moment in a server's life

    url = f"{base_url}/?{urlencode({'key': key})}"
    code = io.StringIO()
    segno.make(url, error="l").terminal(out=code, compact=True)
    console.print("[bold]A key was made for this server. It is shown this once:[/bold]")
    for line in (f"  key   {key}", f"  open  {url}", code.getvalue()):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    console.print(f"Its hash is in {path}. `snapfit key` adds, lists and removes keys.")


def reachable_host(host: str) -> str:
    """A host that other machines can ask for, where a server listens at all addresses."""
    if host not in _ANY_HOST:
        return host
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(_SOMEWHERE)
        except OSError:  # no network at all
            return "127.0.0.1"
        address: str = probe.getsockname()[0]
        return address
