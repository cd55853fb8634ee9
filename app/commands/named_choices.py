"""What somebody names on the command line, comma-separated: methods, faults, sites, floors."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TypeVar

from app.errors import InvalidInput

Known = TypeVar("Known")


def split_names(named: str) -> list[str]:
    """`a, b` as two names; nothing as none."""
    return [name.strip() for name in named.split(",") if name.strip()]


def chosen(named: str, known: Mapping[str, Known], field: str) -> dict[str, Known]:
    """Those that are named, or `all`.

    Raises
    ------
    InvalidInput : one is not known, or none is named; names the field and the choices.
    """
    names = list(known) if named == "all" else split_names(named)
    refuse_unknown(names, known, field)
    return {name: known[name] for name in names}


def refuse_unknown(names: Sequence[str], known: Collection[str], field: str) -> None:
    """Nothing, if there is at least one name and all are known; raises as `chosen` does."""
    unknown = [name for name in names if name not in known]
    if unknown or not names:
        raise InvalidInput(f"no {field} {', '.join(unknown) or 'named'}; there are {', '.join(known)}", field)
