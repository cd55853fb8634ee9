"""What identifiers of venues and floors look like, and what is told of a venue or a version that there is not."""

from __future__ import annotations

import re

from app.errors import InvalidInput, NotFound

IDENTIFIER = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")


def is_identifier(text: str) -> bool:
    """Whether a venue or floor can be called that. What cannot is not asked for: PostgreSQL fails over a NUL."""
    return IDENTIFIER.fullmatch(text) is not None


def refuse_identifier(text: str, field: str) -> None:
    """Nothing, if a venue or floor can be called that.

    Raises
    ------
    InvalidInput : it cannot; names the field.
    """
    if not is_identifier(text):
        raise InvalidInput(
            f"{field} {text[:64]!r} is no identifier: it has 1 to 64 letters, digits, dots, dashes and underscores, "
            "the first a letter or digit",
            field,
        )


def no_venue(venue: str) -> NotFound:
    """The error to raise for a venue that is not there."""
    return NotFound(f"there is no venue {venue[:64]!r}")


def no_version(venue: str, version: int) -> NotFound:
    """The same for a radio map."""
    return NotFound(f"venue {venue[:64]!r} has no radio map version {version}")
