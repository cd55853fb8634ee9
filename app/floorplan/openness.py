"""Whether a place lies in a corridor, where one can go two ways only, or in the open.

Adaptive filter paper section 4.1: the "path environment". Told by the floor plan where there is one; without it by the
strength of the WiFi signal, as in the paper.
"""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from app.estimation.arrays import FloatArray
from app.floorplan.free_space import NO_PLAN, FreeSpace

CORRIDOR_BELOW_M = 5.0
"""Corridors of offices and hospitals are 2 to 4 m wide, the ways between shops 6 and more."""
REACH_M, STRIDE_M, DIRECTIONS = 6.0, 0.5, 8
"""How far, how densely and in how many directions (over half a turn) free space is looked for."""
STRONG_DBM = -55.0
"""A corridor's access points hang above the walker: there the strongest ones arrive louder than this."""
STRONGEST = 3


class Surroundings(StrEnum):
    """Where somebody walks."""

    CORRIDOR = "corridor"
    OPEN = "open"


def free_width_m(space: FreeSpace, xy_m: FloatArray) -> float:
    """The narrowest way across a place (2,), metres: through it in a straight line from edge to edge.

    Returns
    -------
    0 where nobody can be, 2 REACH_M and more where no edge is near.
    """
    angle_rad = np.arange(DIRECTIONS) * (math.pi / DIRECTIONS)
    along = np.arange(1, int(REACH_M / STRIDE_M) + 1) * STRIDE_M
    unit = np.column_stack([np.sin(angle_rad), np.cos(angle_rad)])
    rays = np.concatenate([unit, -unit])[:, np.newaxis, :] * along[:, np.newaxis]
    free = space.is_free(np.concatenate([xy_m[np.newaxis, :], (xy_m + rays).reshape(-1, 2)]))
    if not free[0]:
        return 0.0
    reached_m = STRIDE_M * np.cumprod(free[1:].reshape(2, DIRECTIONS, len(along)), axis=2).sum(axis=2)
    return float(reached_m.sum(axis=0).min()) + STRIDE_M


def surroundings_of(rssi_dbm: FloatArray, xy_m: FloatArray, space: FreeSpace = NO_PLAN) -> Surroundings:
    """Corridor or open.

    Parameters
    ----------
    rssi_dbm : (n,) of the newest scan's fresh readings; none count as open, the more cautious of the two.
    xy_m, space : (2,) the place, and the floor's plan; without a plan, or where it says that nobody can be there, the
        signal decides.
    """
    width_m = free_width_m(space, xy_m) if space.walled else 0.0
    if width_m > 0.0:
        return Surroundings.CORRIDOR if width_m < CORRIDOR_BELOW_M else Surroundings.OPEN
    if len(rssi_dbm) == 0:
        return Surroundings.OPEN
    loudest_dbm = float(np.sort(rssi_dbm)[-STRONGEST:].mean())
    return Surroundings.CORRIDOR if loudest_dbm > STRONG_DBM else Surroundings.OPEN
