"""What is remembered of a carried phone's motion: its attitude, and the last seconds of what it felt.

Two rings: accelerations averaged over cells of 40 ms, whatever the phone's rate, and poses, the quaternion with its
covariance, a few times a second.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from app.estimation.arrays import FloatArray

CELL_S = 0.04
CELLS, POSES, CELLS_A_POSE = 128, 32, 4
"""Lengths of the rings: 5 s, since the first steps of a walk are told up to 4.5 s late."""
TIME, EAST, NORTH, UP, NORM, FACES, TURNED, POINTS = range(8)
"""Columns of a cell: middle (s), acceleration without gravity (m/s^2), norm with it, how
far the screen faces up (1: flat, 0: upright, -1: down), turn so far and azimuth (rad)."""
POSE_TIME, POSE_Q, POSE_COVARIANCE = 0, 1, 5
"""Columns of a pose: time, quaternion (4), its covariance (16)."""
STARTED, SEEKS_NORTH, ABSOLUTE, TURN, NORM_REF, DIP_REF, FIELD_S, CELL, IN_CELL, KEPT, POSED, POINTED = range(12)
"""Elements of `scalars`: how often the attitude was begun, flags, clockwise turn so far (rad), the site's field and
for how long it is known, the open cell and its samples, cells and poses ever written, newest azimuth (rad)."""


def _no_pose() -> FloatArray:
    return np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class CarriedMotion:
    """What is remembered: time_s (4,) newest sample of each sensor, rate (3,) newest, quaternion (4,) and covariance
    (4, 4), scalars (12,), sums (8,) of the open cell, cells (128, 8) and poses (32, 21) rings."""

    time_s: FloatArray = field(default_factory=lambda: np.full(4, -math.inf))
    rate: FloatArray = field(default_factory=lambda: np.zeros(3))
    quaternion: FloatArray = field(default_factory=_no_pose)
    covariance: FloatArray = field(default_factory=lambda: np.zeros((4, 4)))
    scalars: FloatArray = field(default_factory=lambda: np.zeros(12))
    sums: FloatArray = field(default_factory=lambda: np.zeros(8))
    cells: FloatArray = field(default_factory=lambda: np.zeros((CELLS, 8)))
    poses: FloatArray = field(default_factory=lambda: np.zeros((POSES, 21)))

    def arrays(self) -> tuple[FloatArray, ...]:
        """Writable copies in the order of `carry`'s arguments."""
        return (
            self.time_s.copy(),
            self.rate.copy(),
            self.quaternion.copy(),
            self.covariance.copy(),
            self.scalars.copy(),
            self.sums.copy(),
            self.cells.copy(),
            self.poses.copy(),
        )

    @property
    def is_absolute(self) -> bool:
        """Whether the azimuth is from north."""
        return bool(self.scalars[ABSOLUTE] > 0.0)

    @property
    def frame(self) -> int:
        """Number of the frame that headings are in: another one after every gap."""
        return int(self.scalars[STARTED])

    def cells_between(self, after_s: float, until_s: float) -> FloatArray:
        """(n, 8) kept cells whose middle is in (after_s, until_s], in order of time."""
        kept = int(self.scalars[KEPT])
        cells = self.cells[:kept] if kept <= CELLS else np.roll(self.cells, -(kept % CELLS), axis=0)
        first, last = np.searchsorted(cells[:, TIME], [after_s, until_s], side="right")
        return cells[first:last]

    def pose_near(self, time_s: float) -> tuple[FloatArray, FloatArray]:
        """Quaternion (4,) and covariance (4, 4) of the kept pose nearest to a time."""
        posed = min(int(self.scalars[POSED]), POSES)
        if posed == 0:
            return self.quaternion, self.covariance
        pose = self.poses[int(np.abs(self.poses[:posed, POSE_TIME] - time_s).argmin())]
        return pose[POSE_Q:POSE_COVARIANCE], pose[POSE_COVARIANCE:].reshape(4, 4)
