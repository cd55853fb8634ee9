"""RSSI as numbers that distances make sense of: 0 is not heard, and more is stronger.

Torres-Sospedra et al. 2015, "Comprehensive analysis of distance and similarity measures for Wi-Fi fingerprinting indoor
positioning systems", section 3.2. An access point that is missing is 0 in each: under `powed` that says little, since
what is nearly too weak to be heard is nearly 0 as well.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from app.estimation.arrays import Float32Array

STRONGEST_DBM = 0.0
"""Readings are clipped here from above: what is stronger is no WiFi."""


class Shape(StrEnum):
    """How the height above zero_dbm becomes a number. With RAW a reading below zero_dbm stays negative: under the
    Euclidean distance that is the plain RSSI with zero_dbm filled in for missing access points."""

    RAW = "raw"
    POSITIVE = "positive"
    EXPONENTIAL = "exponential"
    POWED = "powed"


@dataclass(frozen=True, slots=True)
class Representation:
    """zero_dbm : counts as not heard.  steepness_db : of EXPONENTIAL, exponent : of POWED; both as in the paper."""

    shape: Shape = Shape.POWED
    zero_dbm: float = -105.0
    steepness_db: float = 24.0
    exponent: float = math.e


POWED = Representation()
SQUARED = Representation(exponent=2.0)


def represent(rssi_dbm: NDArray[np.floating], representation: Representation = POWED) -> Float32Array:
    """Values of heard readings, any shape; at least 0 but for RAW, at most 1 for EXPONENTIAL and POWED."""
    zero_dbm = representation.zero_dbm
    height_db = np.minimum(np.asarray(rssi_dbm, np.float64), STRONGEST_DBM) - zero_dbm
    if representation.shape is Shape.RAW:
        return height_db.astype(np.float32)
    height_db = np.maximum(height_db, 0.0)
    match representation.shape:
        case Shape.EXPONENTIAL:
            value = np.where(height_db > 0.0, np.exp((height_db + zero_dbm) / representation.steepness_db), 0.0)
        case Shape.POWED:
            value = (height_db / -zero_dbm) ** representation.exponent
        case _:
            value = height_db
    return value.astype(np.float32)
