"""MAC addresses of access points as 48-bit integers: what arrays hold instead of text."""

from __future__ import annotations

import re
from functools import lru_cache

_MAC = re.compile(r"[0-9a-fA-F]{12}|[0-9a-fA-F]{2}(?:([:-])[0-9a-fA-F]{2})(?:\1[0-9a-fA-F]{2}){4}")
_SEPARATORS = str.maketrans("", "", ":-")


@lru_cache(1 << 16)  # the same few thousand, over and over
def parse_bssid(text: str) -> int:
    """The 48-bit integer of `a8:0c:ca:03:9d:d7`, `A8-0C-CA-03-9D-D7` or `a80cca039dd7`.

    Raises
    ------
    ValueError : anything else.
    """
    if _MAC.fullmatch(text) is None:
        raise ValueError(f"not a MAC address: {text[:40]!r}")
    return int(text.translate(_SEPARATORS), 16)


def format_bssid(bssid: int) -> str:
    """Lower case, colons."""
    return int(bssid).to_bytes(6, "big").hex(":")
