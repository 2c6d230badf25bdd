"""From an HTTP response to what it says: a value, or the error of its problem body."""

from __future__ import annotations

from typing import NoReturn, TypeVar

import httpx
from pydantic import BaseModel, ValidationError

from snapfit.clients.python import errors
from snapfit.clients.python.errors import ClientError, ProblemError, UnexpectedAnswerError

PROBLEM_TYPE = "application/problem+json"
_GATEWAY = {502, 504}
_URN = "urn:snapfit:problem:"
_BY_STATUS: dict[int, type[ProblemError]] = {
    400: errors.InvalidRequestError,
    401: errors.NotAllowedError,
    403: errors.NotAllowedError,
    404: errors.NotFoundError,
    409: errors.NotPossibleError,
    413: errors.InvalidRequestError,
    422: errors.InvalidRequestError,
    429: errors.TooManyRequestsError,
    500: errors.ServerFaultError,
    503: errors.NotReadyError,
}
KINDS: dict[str, type[ProblemError]] = {
    each.kind_of_class: each
    for each in vars(errors).values()
    if isinstance(each, type) and issubclass(each, ProblemError) and each.kind_of_class
}
"""The class of each kind of problem."""

ModelT = TypeVar("ModelT", bound=BaseModel)


def parsed(model: type[ModelT], body: bytes | str, path: str) -> ModelT:
    """The answer as its type.

    Raises:
        UnexpectedAnswerError: it is not of this type.
    """
    try:
        return model.model_validate_json(body)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the body"
        raise UnexpectedAnswerError(
            f"{path} answered no {model.__name__}: {where}: {first['msg']}. Is this a snapfit "
            "server, and of this client's version?"
        ) from error


def check(response: httpx.Response) -> None:
    """Nothing, if the answer is none of an error; its body must have been read.

    Raises:
        ProblemError: of the class of its kind.
        UnexpectedAnswerError: an error that is not snapfit's.
    """
    if response.status_code >= 400 or 300 < response.status_code < 304:
        retry_after = response.headers.get("retry-after")
        kind = response.headers.get("content-type", "").partition(";")[0]
        path = response.request.url.raw_path.decode().partition("?")[0]
        raise problem(response.status_code, kind, response.content, retry_after, path)


def problem(
    status: int, content_type: str, body: bytes, retry_after: str | None, path: str
) -> ClientError:
    """The error that an answer of at least 400 tells."""
    if content_type != PROBLEM_TYPE:
        return UnexpectedAnswerError(
            f"{path} answered {status} and no problem body: this is no snapfit server, or a proxy "
            "before it answers in its place. Check the address.",
            is_gateway=status in _GATEWAY,
        )
    members = parsed(_Problem, body, path)
    kind = members.type.removeprefix(_URN) if members.type.startswith(_URN) else ""
    known = KINDS.get(kind) or _BY_STATUS.get(status, ProblemError)
    wait_s = float(retry_after) if retry_after and retry_after.isdecimal() else None
    return known(kind, status, members.detail, path, wait_s, members.model_extra)


def unreachable(url: str, error: Exception) -> NoReturn:
    """Tell why there was no answer.

    Raises:
        CertificateError: the server's certificate is not trusted.
        NotReachableError: for any other reason.
    """
    told = str(error) or type(error).__name__
    if "CERTIFICATE_VERIFY_FAILED" in told:
        raise errors.CertificateError(
            f"{url}: its certificate is not trusted ({told}). Pass verify='ca.pem', the file of "
            "the authority that signed it, or of the certificate itself."
        ) from error
    what = "took too long" if isinstance(error, httpx.TimeoutException | TimeoutError) else "failed"
    raise errors.NotReachableError(
        f"{url} does not answer: {what} ({told}). Is the server running there, is the port right, "
        "and is it http or https?"
    ) from error


class _Problem(BaseModel, extra="allow"):
    type: str = "about:blank"
    title: str
    status: int
    detail: str
    instance: str
