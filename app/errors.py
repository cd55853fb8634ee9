"""The exception tree of the service. No HTTP here: app/api/problems.py maps each leaf to a status.

SurefixError
├── InvalidInput            what the caller sent cannot be used; names the field
│   ├── TooLarge            a well-formed thing beyond a documented bound
│   └── UnsupportedMedia    a media type or content encoding that is not read here
├── NotFound                venue, floor, session, survey, version: the identifier is unknown
├── Expired                 a session that existed and is over
├── Conflict                the request contradicts what is stored (older sequence, duplicate venue)
├── NotAllowed
│   ├── Unauthenticated     no key, or an unknown one
│   ├── Forbidden           a valid key without the scope
│   └── NotLocal            without keys: a request that is not this machine's own
└── DependencyDown          database or session store unreachable; try again later
"""

from __future__ import annotations

import errno


class SurefixError(Exception):
    """Root of everything this service raises on purpose; the message is written for the caller."""


class InvalidInput(SurefixError):
    """Input that cannot be used.

    Parameters
    ----------
    message : what is wrong and how to mend it.
    field : where, as a dotted path with indices (``wifi[0].readings``); empty for the whole body.
    """

    def __init__(self, message: str, field: str = "") -> None:
        super().__init__(message)
        self.field = field


class TooLarge(InvalidInput):
    """A well-formed input beyond a documented bound."""


class UnsupportedMedia(InvalidInput):
    """A media type or content encoding that is not read here."""


class NotFound(SurefixError):
    """The identifier names nothing that exists. field : as of InvalidInput; empty for one that is in the path."""

    def __init__(self, message: str, field: str = "") -> None:
        super().__init__(message)
        self.field = field


class Expired(SurefixError):
    """The session existed and is over."""


class Conflict(SurefixError):
    """The request contradicts what is stored."""


class NotAllowed(SurefixError):
    """The caller may not do this."""


class Unauthenticated(NotAllowed):
    """No API key, or one that is unknown or revoked."""


class Forbidden(NotAllowed):
    """The API key is valid but lacks the scope."""


class NotLocal(NotAllowed):
    """No key is needed of this machine, and the request is of another, or of a web page of another."""


class DependencyDown(SurefixError):
    """A database or session store cannot be reached; the request changed nothing and may be repeated."""

    def __init__(self, message: str, retry_after_s: int = 2) -> None:
        super().__init__(message)
        self.retry_after_s = retry_after_s


def told_as(error: Exception) -> Exception:
    """What an error is told as: itself, but of a full disk, which is no defect, a DependencyDown."""
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
        return DependencyDown(f"the disk of the service is full: {error.strerror}")
    return error
