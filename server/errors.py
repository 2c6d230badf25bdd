"""The errors of the server. Each says what is wrong, where, and what to do."""

from __future__ import annotations

from pathlib import Path

from snapfit.models.errors import SnapfitError


class SettingsError(SnapfitError):
    """A setting that is refused; names the file (or the environment) and the key."""

    def __init__(self, origin: Path | str, problems: list[str]) -> None:
        super().__init__("\n".join(f"{origin}: {problem}" for problem in problems))
        self.origin = origin
        self.problems = problems


class PortInUseError(SnapfitError):
    """Another program listens at the address that the server was given."""

    def __init__(self, host: str, port: int) -> None:
        super().__init__(
            f"port {port} on {host} is in use: choose another one with --port, "
            f"for instance --port {port + 1}"
        )
        self.host = host
        self.port = port


class AddressError(SnapfitError):
    """A host that this machine cannot listen at."""


class InstallationError(SnapfitError):
    """A file of snapfit's own that is missing."""


class StoreError(SnapfitError):
    """A shared memory that is missing, of another version, damaged, or too small for a message."""


class BoardError(SnapfitError):
    """A board that cannot be, or does not fit the paper."""


class WorkerRefusedError(SnapfitError):
    """A worker that could not start because of a file or a setting, in the worker's words."""


class KeyFileError(SnapfitError):
    """A file of API keys that cannot be read or written, or a key that it does not have."""

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path


class TlsError(SnapfitError):
    """A certificate or private key that cannot be used; names the file."""


class WatchError(SnapfitError):
    """A server that cannot be watched, in the words of the client."""
