"""The two roles: who reads, and who also operates."""

from __future__ import annotations

from enum import StrEnum

SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


class Role(StrEnum):
    """What a key is good for."""

    READ = "read"
    OPERATE = "operate"

    def may(self, needed: Role) -> bool:
        """Whether this role is enough; who operates also reads."""
        return self is Role.OPERATE or needed is Role.READ


def role_for(method: str) -> Role:
    """The role that a request of this HTTP method needs: whatever may change something operates."""
    return Role.READ if method in SAFE_METHODS else Role.OPERATE
