"""TLS: the certificate is looked at before the server starts."""

from __future__ import annotations

import ssl
from pathlib import Path

from snapfit.server.errors import TlsError
from snapfit.server.security.settings import SecuritySettings


def uses_tls(security: SecuritySettings) -> bool:
    """Whether the server speaks HTTPS.

    Raises:
        TlsError: only one of certificate and key is given.
    """
    if (security.tls_cert is None) != (security.tls_key is None):
        raise TlsError("TLS needs both files: --tls-cert and --tls-key")
    return security.tls_cert is not None


def check_tls(security: SecuritySettings) -> None:
    """Load certificate and key once, so that what is wrong with them is told in a line.

    Raises:
        TlsError: a file is missing or no PEM, the key is encrypted, or they do not belong together.
    """
    if not uses_tls(security) or security.tls_cert is None or security.tls_key is None:
        return
    for name in (security.tls_cert, security.tls_key):
        if not Path(name).is_file():
            raise TlsError(f"{name}: no such file")
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        # No password: OpenSSL would ask for it in the terminal.
        context.load_cert_chain(security.tls_cert, security.tls_key, password=lambda: "")
    except (ssl.SSLError, OSError) as error:
        raise TlsError(
            f"{security.tls_cert} and {security.tls_key} are no certificate in PEM with its "
            f"private key, not encrypted: {error}"
        ) from error
