"""The evidence behind a Fix to bytes and back: what is kept so that its track can be smoothed afterwards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np
import ormsgpack

from app.errors import DependencyDown
from app.observations import Fix, Motion, RadioFix, Step

FORMAT = 2
_NUMBERS_OF_STEP = 7
"""The first of its fields: smoothing does not ask how a phone is held."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """motion : what the walker did at the end.  measured : since the Fix before, in the order in which it came.
    floor_certain, unsurveyed_m2 : as of the Fix."""

    motion: Motion
    measured: tuple[Step | RadioFix, ...]
    floor_certain: bool = True
    unsurveyed_m2: float = 0.0


def encode_evidence(fix: Fix) -> bytes:
    """What a Fix was made of, as bytes: some 65 a step, 90 a scan."""
    measured = [_packed(one) for one in fix.evidence]
    return ormsgpack.packb([FORMAT, fix.motion.value, measured, bool(fix.floor_certain), float(fix.unsurveyed_m2)])


def decode_evidence(encoded: bytes) -> Evidence:
    """What encode_evidence wrote. Format 1 did not say whether the floor was certain: it counts as not, and no level is
    smaller than it was.

    Raises
    ------
    DependencyDown : these are not such bytes; the store has lost some.
    """
    try:
        layout, motion, measured, *known = ormsgpack.unpackb(encoded)
        if layout not in (1, FORMAT):
            raise ValueError(f"format {layout}, not {FORMAT}")
        certain, unsurveyed_m2 = (False, 0.0) if layout == 1 else known
        return Evidence(Motion(motion), tuple([_unpacked(row) for row in measured]), certain, unsurveyed_m2)
    except (ValueError, TypeError, IndexError) as error:
        raise DependencyDown(f"the stored evidence of a fix cannot be read: {error}") from error


def _packed(one: Step | RadioFix) -> list[Any]:
    if isinstance(one, Step):
        return list(astuple(one)[:_NUMBERS_OF_STEP])
    xx, xy, yy = (float(one.noise_m2[row, column]) for row, column in ((0, 0), (0, 1), (1, 1)))
    x_m, y_m = (float(value) for value in one.xy_m)
    lasting_m2, distance = float(one.lasting_m2), float(one.signal_distance)
    return [one.floor, float(one.time_s), x_m, y_m, xx, xy, yy, lasting_m2, distance, bool(one.fits), one.source]


def _unpacked(row: Sequence[Any]) -> Step | RadioFix:
    """A scan's row begins with the name of its floor, a step's is all numbers."""
    if not isinstance(row[0], str):
        if len(row) != _NUMBERS_OF_STEP:
            raise ValueError(f"a step of {len(row)} numbers")
        return Step(*row)
    floor, time_s, x_m, y_m, xx, xy, yy, lasting_m2, distance, fits, source = row
    noise_m2 = np.array([[xx, xy], [xy, yy]])
    return RadioFix(time_s, floor, np.array([x_m, y_m]), noise_m2, lasting_m2, distance, fits, source)
