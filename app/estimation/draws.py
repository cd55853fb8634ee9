"""Numbers that look drawn by chance and are not: a function of a key and an index, the same on every worker.

A hash of a counter (SplitMix64's finaliser, Steele, Lea and Flood 2014) needs no state that a thread could share, so
filters with particles stay pure: the same events give the same cloud.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

_STEP, _FIRST, _SECOND = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_30, _27, _31, _11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_UNIT = 2.0**-53


@njit(cache=True, nogil=True)
def _mixed(word: np.uint64) -> np.uint64:
    word = (word ^ (word >> _30)) * _FIRST
    word = (word ^ (word >> _27)) * _SECOND
    return word ^ (word >> _31)


@njit(cache=True, nogil=True)
def uniform(key: int, index: int) -> float:
    """In (0, 1]. key : one for each time something is drawn.  index : of the number, 0 or more."""
    word = _mixed(_mixed(np.uint64(key) * _STEP) + (np.uint64(index) + np.uint64(1)) * _STEP)
    return (float(word >> _11) + 1.0) * _UNIT


@njit(cache=True, nogil=True)
def normals(key: int, index: int) -> tuple[float, float]:
    """Two independent standard normal numbers (Box and Muller 1958). key, index : as of uniform; uses 2 index and
    2 index + 1."""
    radius = math.sqrt(-2.0 * math.log(uniform(key, 2 * index)))
    angle_rad = 2.0 * math.pi * uniform(key, 2 * index + 1)
    return radius * math.cos(angle_rad), radius * math.sin(angle_rad)
