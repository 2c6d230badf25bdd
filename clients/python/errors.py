"""What can go wrong, one class for each kind of problem, each with what to do."""

from __future__ import annotations

from typing import Any, ClassVar


class ClientError(Exception):
    """Base of all errors of this client; its text says what is wrong and what to do."""


class NotReachableError(ClientError):
    """No answer: nothing listens there, the network is down, or it took too long."""


class CertificateError(NotReachableError):
    """The server's certificate is not trusted: pass `verify="ca.pem"`, or mend the certificate."""


class UnexpectedAnswerError(ClientError):
    """An answer that is not snapfit's, or that of another version.

    Attributes:
        is_gateway: a proxy says that the server behind it does not answer (502, 504).
    """

    def __init__(self, text: str, *, is_gateway: bool = False) -> None:
        super().__init__(text)
        self.is_gateway = is_gateway


class ProblemError(ClientError):
    """An answer that says why there is no other one: problem details, RFC 9457.

    Attributes:
        kind: what kind of problem, without `urn:snapfit:problem:`; empty where it has none.
        status: the HTTP status.
        detail: what is wrong and what to do, in the server's words.
        path: what was asked for.
        retry_after_s: when it is worth trying again; None where the server does not say.
        members: further members of the body.
    """

    kind_of_class: ClassVar[str] = ""
    hint: ClassVar[str] = ""

    def __init__(
        self,
        kind: str,
        status: int,
        detail: str,
        path: str,
        retry_after_s: float | None = None,
        members: dict[str, Any] | None = None,
    ) -> None:
        super().__init__(f"{detail} {self.hint}".strip())
        self.kind = kind
        self.status = status
        self.detail = detail
        self.path = path
        self.retry_after_s = retry_after_s
        self.members = members or {}

    @property
    def names(self) -> tuple[str, ...]:
        """The names that there are, where one was asked for that is not."""
        for member in ("names", "parts", "stations", "assets", "steps", "anchors"):
            if isinstance(self.members.get(member), list):
                return tuple(self.members[member])
        return ()


class NotAllowedError(ProblemError):
    """401 or 403: this client may not do that."""


class KeyNeededError(NotAllowedError):
    """The server asks for a key."""

    kind_of_class = "key-needed"
    hint = "In Python: Client(url, key=...), or the environment's SNAPFIT_KEY."


class WrongKeyError(NotAllowedError):
    """The key is none of the server's, or no more."""

    kind_of_class = "wrong-key"


class RoleNeededError(NotAllowedError):
    """The key is good for less: commands and anchors need the role `operate`."""

    kind_of_class = "role-needed"


class ForeignOriginError(NotAllowedError):
    """A header `Origin` that the server does not let in."""

    kind_of_class = "foreign-origin"


class ForeignHostError(NotAllowedError):
    """The server does not answer under this name."""

    kind_of_class = "foreign-host"


class TooManyRequestsError(ProblemError):
    """429: wait for `retry_after_s`."""

    kind_of_class = "too-many-requests"


class NotFoundError(ProblemError):
    """404: there is no such thing."""


class UnknownStationError(NotFoundError):
    """There is no such station; `names` has those that there are."""

    kind_of_class = "unknown-station"


class WhichStationError(NotFoundError):
    """The server has several stations; `names` has them."""

    kind_of_class = "which-station"
    hint = "In Python: Client(url, station=...)."


class UnknownPartError(NotFoundError):
    """There is no such part (409 where it was named in a command); `names` has those there are."""

    kind_of_class = "unknown-part"


class UnknownStepError(NotFoundError):
    """There is no such step; `names` has those that there are."""

    kind_of_class = "unknown-step"


class UnknownAssetError(NotFoundError):
    """No station assembles this asset; `names` has those that there are."""

    kind_of_class = "unknown-asset"


class UnknownMediaError(NotFoundError):
    """The asset has no such picture or film."""

    kind_of_class = "unknown-media"


class UnknownAnchorError(NotFoundError):
    """There is no such anchor, or no more: put it again."""

    kind_of_class = "unknown-anchor"


class NoAssemblyError(NotFoundError):
    """Nothing follows an assembly at this station."""

    kind_of_class = "no-assembly"


class AssemblyFinishedError(NotFoundError):
    """There is no current step: nothing is left to do."""

    kind_of_class = "assembly-finished"


class NoStepsError(NotFoundError):
    """The asset has no steps, and so no activity for players of ARLEM."""

    kind_of_class = "no-steps"


class NotPossibleError(ProblemError):
    """409: it cannot be done now."""


class UnknownStateError(NotPossibleError):
    """There is no such assembly state; `names` has those that there are."""

    kind_of_class = "unknown-state"


class AnchorNotAlignedError(NotPossibleError):
    """The camera has not seen the anchor's board yet."""

    kind_of_class = "anchor-not-aligned"


class TooManyAnchorsError(NotPossibleError):
    """The station keeps no more anchors."""

    kind_of_class = "too-many-anchors"


class AtOutOfRangeError(NotPossibleError):
    """`at_us` is far from now by the server's clock."""

    kind_of_class = "at-out-of-range"
    hint = "In Python: client.time_offset() tells the server's time."


class NoDetectorError(NotPossibleError):
    """Nothing would find the parts again."""

    kind_of_class = "no-detector"


class NothingToCommandError(NotPossibleError):
    """The station's method keeps nothing from frame to frame."""

    kind_of_class = "nothing-to-command"


class SourceEndedError(NotPossibleError):
    """The station's source has ended."""

    kind_of_class = "source-ended"


class NotReadyError(ProblemError):
    """503: not yet, or not at the moment; try again after `retry_after_s`."""

    kind_of_class = "not-ready"


class NoPosesYetError(NotReadyError):
    """The station has no snapshot yet."""

    kind_of_class = "no-poses-yet"


class NoPictureError(NotReadyError):
    """The station has no picture yet."""

    kind_of_class = "no-picture"


class WorkerUnavailableError(NotReadyError):
    """The station's worker is down or does not answer; nothing was done."""

    kind_of_class = "worker-unavailable"


class StoreUnavailableError(NotReadyError):
    """The store that several machines share does not answer; the anchor was not changed."""

    kind_of_class = "store-unavailable"


class NoAssetYetError(NotReadyError):
    """The station's worker has not handed its asset over yet."""

    kind_of_class = "no-asset-yet"


class AssetGoneError(NotReadyError):
    """The asset's files are not in the server's cache; the message says what to do."""

    kind_of_class = "asset-gone"


class InvalidRequestError(ProblemError):
    """400, 413, 416 or 422: a parameter or a body is wrong; `members["errors"]` tells where."""

    kind_of_class = "invalid-request"


class BodyTooLongError(InvalidRequestError):
    """The body is longer than the server takes."""

    kind_of_class = "body-too-long"


class NoHttpError(InvalidRequestError):
    """The request is none: a control character in a header, or a space in the address."""

    kind_of_class = "no-http"


class BeyondTheFileError(InvalidRequestError):
    """416: a range of bytes that the file does not have."""

    kind_of_class = "beyond-the-file"


class ServerFaultError(ProblemError):
    """500: the server made a mistake; its log tells more."""


class NoAssetError(ClientError):
    """The station has no asset, or none yet."""
