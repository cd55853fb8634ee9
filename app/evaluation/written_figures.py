"""Figures as they are written: in tables, where a dash stands for none, and in JSON, where null does."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, is_dataclass
from typing import Any


def number(value: float | None, digits: int) -> str:
    """The value with so many decimals."""
    return "-" if value is None or not math.isfinite(value) else f"{value:.{digits}f}"


def percent(value: float | None, digits: int = 1) -> str:
    """A share in per cent, with the sign."""
    return "-" if value is None or not math.isfinite(value) else f"{100.0 * value:.{digits}f} %"


def plain(node: Any) -> Any:
    """Dataclasses, mappings and sequences of figures as JSON holds them."""
    if is_dataclass(node) and not isinstance(node, type):
        node = asdict(node)
    if isinstance(node, Mapping):
        return {str(key): plain(value) for key, value in node.items()}
    if isinstance(node, list | tuple):
        return [plain(value) for value in node]
    return None if isinstance(node, float) and not math.isfinite(node) else node
