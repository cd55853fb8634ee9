"""Direction of walking from the newest WiFi fixes: the line through them, signed by progress.

Two-stage WiFi/MEMS integration, Micromachines 2019, 10, 198, section 4.2 (docs/methods/two_stage_ekf.md).
"""

from __future__ import annotations

import math

import numpy as np

from app.estimation.arrays import FloatArray

FIXES = 4
"""The paper's."""


def direction_of(fixes_m: FloatArray, least_progress_m: float) -> float | None:
    """Heading (rad, clockwise from north) along the least-squares line through fixes.

    Parameters
    ----------
    fixes_m : (FIXES, 2) oldest first.
    least_progress_m : from the first to the last along the line; less is their error and not a way.

    Returns
    -------
    None with too few fixes, or too little progress.

    Notes
    -----
    Differs from the paper: distances to the line are taken across it, not along y, so that a walk due north has a line
    too.
    """
    if len(fixes_m) < FIXES:
        return None
    apart_m = fixes_m - fixes_m.mean(axis=0)
    xx, yy, xy = (apart_m[:, 0] ** 2).sum(), (apart_m[:, 1] ** 2).sum(), (apart_m[:, 0] * apart_m[:, 1]).sum()
    from_east = 0.5 * math.atan2(2.0 * xy, xx - yy)
    along = np.array([math.cos(from_east), math.sin(from_east)])
    progress_m = float((fixes_m[-1] - fixes_m[0]) @ along)
    if not abs(progress_m) >= least_progress_m:
        return None
    along *= math.copysign(1.0, progress_m)
    return math.atan2(float(along[0]), float(along[1]))
