"""Compile everything that the methods run before the first request needs it."""

from __future__ import annotations

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.fusion.interface import Floor, SessionStart, Site
from app.fusion.methods import METHODS
from app.fusion.state_codec import decode_state, encode_state
from app.fusion.track_smoothing import smoothed
from app.fusion.walk_timeline import Moment
from app.observations import AxisSamples, Batch, Fix, Motion, WifiScan
from app.wifi import kernels as wifi_kernels
from app.wifi.fingerprint import Fingerprint
from app.wifi.radio_map import build_radio_map

SECONDS = 8
AWAY_FROM_S = 6
"""From here on scans are of a place far off, which no track allows."""
RATE_HZ = 50


def warm_up() -> None:
    """Take every compiled function through the types that requests use; a few seconds from the cache.

    Every method walks some seconds, its state stored in between, as a service does it, and the walk is smoothed.
    """
    wifi_kernels.warm_up()
    site, batches = _small_site(), [_walking(second) for second in range(SECONDS)]
    for method in METHODS.values():
        state, fixes = method.start(SessionStart()), list[Fix]()
        for batch in batches:
            state, fix = method.advance(decode_state(encode_state(state)), batch, site)
            fixes.append(fix)
        evidence = [one for fix in fixes for one in fix.evidence]
        smoothed(evidence, [Moment(batch.end_s or 0.0, Motion.WALKING) for batch in batches])


def _small_site() -> Site:
    surveyed = [Fingerprint("F1", *_place_m(second), 0.0, "walk", *_heard(second)) for second in range(SECONDS)]
    return Site({"F1": Floor("F1", 0, 120.0, 10.0)}, build_radio_map(surveyed))


def _place_m(second: int) -> tuple[float, float]:
    return 3.0 * second + (80.0 if second >= AWAY_FROM_S else 0.0), 2.0 * (second % 2)


def _heard(second: int) -> tuple[IntArray, FloatArray]:
    """Access points and levels; far off there are others."""
    number = np.arange(1, 6)
    return number + (10 if second >= AWAY_FROM_S else 0), -50.0 - 3.0 * np.abs(number - second % AWAY_FROM_S)


def _walking(second: int) -> Batch:
    time_s = second + (1.0 + np.arange(RATE_HZ)) / RATE_HZ
    force = np.zeros((RATE_HZ, 3))
    force[:, 2] = 9.81 + 3.0 * np.sin(2.0 * np.pi * 1.8 * time_s)
    still = np.zeros((RATE_HZ, 3))
    north = np.tile([0.0, 28.0, -38.0], (RATE_HZ, 1))
    scan = WifiScan(float(time_s[-1]), *_heard(second), np.full(5, time_s[-1]))
    return Batch(
        sequence=second,
        end_s=float(time_s[-1]),
        accelerometer=AxisSamples(time_s, force),
        gyroscope=AxisSamples(time_s, still),
        magnetometer=AxisSamples(time_s, north),
        wifi=(scan,),
    )
