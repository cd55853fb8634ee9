"""Survey scans of one place through a running median, before they are averaged into a reference point.

two_stage_ekf_moving_partition.txt, section 7.1 (methods.md B): a median filter of order five over forty observations a
point. It does something only where a place was scanned more than twice; passers-by seldom do.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.estimation.arrays import FloatArray
from app.wifi.fingerprint import Fingerprint

ORDER = 5
"""The paper's."""


def median_filtered(fingerprints: Sequence[Fingerprint], order: int = ORDER) -> list[Fingerprint]:
    """The same fingerprints, each reading the median of `order` of its access point's readings there, in time.

    Parameters
    ----------
    fingerprints : in any order; those of one place share floor and coordinates.  order : odd.

    Returns
    -------
    In the order of the argument. At the ends of a series the window is what there is of it.
    """
    if order < 1 or order % 2 == 0:
        raise ValueError(f"the order of a running median is odd and positive, not {order}")
    series: dict[tuple[str, float, float, int], list[tuple[float, int, int]]] = defaultdict(list)
    for number, one in enumerate(fingerprints):
        for at, bssid in enumerate(one.bssid.tolist()):
            series[one.floor, one.x_m, one.y_m, bssid].append((one.time_s, number, at))
    filtered: list[FloatArray] = [one.rssi_dbm.astype(np.float64) for one in fingerprints]
    half = order // 2
    for readings in series.values():
        readings.sort()
        values = [float(fingerprints[number].rssi_dbm[at]) for _, number, at in readings]
        for place, (_, number, at) in enumerate(readings):
            filtered[number][at] = np.median(values[max(place - half, 0) : place + half + 1])
    return [replace(one, rssi_dbm=rssi_dbm) for one, rssi_dbm in zip(fingerprints, filtered, strict=True)]
