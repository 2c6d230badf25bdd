"""`python -m snapfit.server.health [STATION]`: a container's health check, without curl.

Without a station: whether the API of this container answers. With one: whether this container's
`snapfit worker` holds the station at the store. Runs every few seconds, so it imports little.
"""

from __future__ import annotations

import http.client
import os
import socket
import ssl
import sys

_TIMEOUT_S = 3.0
_DEFAULT_PORT = "8000"


def main() -> int:
    """0 if all is well, else 1 with a line that says what is not."""
    problem = worker_problem(sys.argv[1]) if len(sys.argv) > 1 else api_problem()
    if problem:
        sys.stderr.write(f"{problem}\n")
    return int(bool(problem))


def api_problem() -> str:
    """What is wrong with the API at this machine's port `SNAPFIT_PORT`; nothing if it is well.

    The port speaks HTTP or, with a certificate, HTTPS.
    """
    port = int(os.environ.get("SNAPFIT_PORT", _DEFAULT_PORT))
    try:
        return _told(port, http.client.HTTPConnection("127.0.0.1", port, timeout=_TIMEOUT_S))
    except (http.client.HTTPException, ConnectionResetError):
        pass  # it did not understand: it speaks HTTPS
    except OSError as error:
        return f"port {port}: {error}"
    # Its certificate is for names that others ask for, not for this machine's own.
    unchecked = ssl.create_default_context()
    unchecked.check_hostname, unchecked.verify_mode = False, ssl.CERT_NONE
    secure = http.client.HTTPSConnection("127.0.0.1", port, timeout=_TIMEOUT_S, context=unchecked)
    try:
        return _told(port, secure)
    except (OSError, http.client.HTTPException) as error:
        return f"port {port}: {error}"


def _told(port: int, connection: http.client.HTTPConnection) -> str:
    """What is wrong by this answer."""
    try:
        connection.request("GET", "/healthz")
        status = connection.getresponse().status
    finally:
        connection.close()
    return "" if status == http.HTTPStatus.OK else f"port {port}: /healthz says {status}"


def worker_problem(station: str) -> str:
    """What is wrong with this machine's worker of a station; nothing if it is well."""
    import redis

    from snapfit.server.fleet.keys import StationKeys
    from snapfit.server.fleet.link import connect
    from snapfit.server.logs.secrets import without_secrets

    url = os.environ.get("SNAPFIT_STORE", "")
    try:
        with connect(url) as client:
            holder = client.get(StationKeys(station).lease)
    except (redis.RedisError, OSError) as error:
        return f"store {without_secrets(url)}: {error}"
    if not isinstance(holder, bytes):
        return f"station {station}: nobody publishes it"
    machine = holder.decode().split(":")[0]
    return "" if machine == socket.gethostname() else f"station {station}: published by {machine}"


if __name__ == "__main__":
    sys.exit(main())
