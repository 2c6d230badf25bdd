"""Headers that every answer carries, so that browsers make nothing else of it than it is.

The HTTP protocol itself writes them: so answers to requests that never reach the app have them
too, and a polling client waits for no middleware.
"""

from __future__ import annotations

# The page needs its own files, pictures that it fetched (blob:), and an icon in its style (data:).
_CSP = (
    "default-src 'self'; img-src 'self' blob: data:; object-src 'none'; base-uri 'none'; "
    "form-action 'self'; frame-ancestors 'none'"
)
SECURITY_HEADERS = [
    ("x-content-type-options", "nosniff"),
    ("content-security-policy", _CSP),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
]
