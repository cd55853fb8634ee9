"""The inner parts of a positioning: matching, a filter step, smoothing. Against scikit-learn and filterpy.

Both are made to give the same answer before they are timed: a faster wrong answer is none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter
from sklearn.neighbors import NearestNeighbors

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray, IntArray
from app.estimation.unscented_kalman import correct
from app.fusion import walking_ukf
from app.fusion.track_smoothing import smoothed
from app.fusion.walk_timeline import Moment
from app.observations import Motion, RadioFix, Step
from app.wifi.fingerprint import Fingerprint
from app.wifi.match_index import index_of
from app.wifi.radio_map import build_radio_map
from app.wifi.representation import represent
from app.wifi.wknn import WknnSettings, wknn
from benchmarks.timing import Row, median_us

ACCESS_POINTS = 2000
HEARD = 300
"""As many a scan as in the open mall."""
STEPS = 1_000, 10_000
"""Of a short session, and of one of some hours."""


def matching(points: int, seed: int = 3) -> Iterator[Row]:
    """Five nearest of many reference points; the reference has them as a dense matrix, cosine distance."""
    rng = np.random.default_rng(seed)
    radio_map = build_radio_map([_fingerprint(rng, number) for number in range(points)], cell_m=0.0)
    scan = _fingerprint(rng, -1)
    index = index_of(radio_map)
    dense = np.zeros((points, len(index.bssid)), np.float32)
    for point in range(points):
        pairs = slice(index.row_start[point], index.row_start[point + 1])
        dense[point, index.column[pairs]] = index.row_value[pairs]
    query = np.zeros((1, len(index.bssid)), np.float32)
    known = np.isin(scan.bssid, index.bssid)
    query[0, np.searchsorted(index.bssid, scan.bssid[known])] = represent(scan.rssi_dbm[known], index.representation)
    settings = WknnSettings()
    search = NearestNeighbors(n_neighbors=settings.neighbours, metric="cosine", algorithm="brute").fit(dense)
    match = wknn(radio_map, scan.bssid, scan.rssi_dbm, settings)
    if match is None or match.points.tolist() != search.kneighbors(query, return_distance=False)[0].tolist():
        raise RuntimeError("matching and scikit-learn disagree")
    ours, reference = median_us(
        lambda: wknn(radio_map, scan.bssid, scan.rssi_dbm, settings), lambda: search.kneighbors(query)
    )
    yield Row(f"WKNN of {HEARD} readings, {points} points", ours, "scikit-learn, dense", reference, at_least=2.0)


def _fingerprint(rng: np.random.Generator, number: int) -> Fingerprint:
    """Neighbouring numbers hear neighbouring access points."""
    place = float(rng.uniform(0.0, 1.0))
    near = np.argsort(np.abs(np.linspace(0.0, 1.0, ACCESS_POINTS) - place) + rng.uniform(0.0, 0.1, ACCESS_POINTS))
    bssid: IntArray = np.sort(near[:HEARD]).astype(np.int64)
    return Fingerprint("F1", 100.0 * place, 0.0, float(number), str(number), bssid, rng.uniform(-95.0, -40.0, HEARD))


def filter_step() -> Iterator[Row]:
    """Prediction and correction of the integrity paper's filter: 3 states, 5 observations."""
    mean, covariance = np.array([10.0, 20.0, 0.3]), np.diag([4.0, 3.0, 0.1])
    q, r = np.array([0.04, 0.05, 0.01]), np.diag([9.0, 7.0, 0.04, 0.01, 0.3])
    measured, length_m, turn_rad = np.array([10.9, 20.1, 0.72, 0.03, 0.4]), 0.7, 0.05
    which, angles = np.arange(5), walking_ukf.angles_of_state(walking_ukf.PLAIN)

    def ours() -> tuple[FloatArray, FloatArray]:
        prior, p = walking_ukf.predict(mean, covariance, length_m, turn_rad, 0.0, 1.0, q, 1.0)
        innovation, pzz, pxz, gain = walking_ukf.expect(prior, p, measured, r, which, mean, 0.0, 1.0)
        return correct(prior, p, innovation, pzz, pxz, gain, angles)

    theirs = UnscentedKalmanFilter(
        3, 5, 1.0, hx=_observed, fx=_moved, points=MerweScaledSigmaPoints(3, 1.0, walking_ukf.BETA, walking_ukf.KAPPA)
    )
    theirs.Q, theirs.R = np.diag(q), r

    def reference() -> FloatArray:
        theirs.x, theirs.P = mean.copy(), covariance.copy()
        theirs.predict(length_m=length_m, turn_rad=turn_rad)
        theirs.update(measured, before=mean)
        return np.asarray(theirs.x)

    if not np.allclose(ours()[0], reference(), atol=1e-9):
        raise RuntimeError("the filter and filterpy's disagree")
    spent, its = median_us(ours, reference)
    yield Row("UKF step, 3 states, 5 observations", spent, "filterpy", its, at_least=10.0)


def _moved(state: FloatArray, _: float, length_m: float, turn_rad: float) -> FloatArray:
    x, y, heading = state
    return np.array([x + length_m * np.sin(heading), y + length_m * np.cos(heading), heading + turn_rad])


def _observed(state: FloatArray, before: FloatArray) -> FloatArray:
    x, y, heading = state
    length = np.hypot(x - before[0], y - before[1])
    return np.array([x, y, length, wrap(heading - before[2]), wrap(heading)])


def smoothing() -> Iterator[Row]:
    """A step of a long session's smoothing beside one of a short session's: the whole must grow in proportion."""
    times_us = [time_us / steps for steps, time_us in zip(STEPS, median_us(*map(_smoothing, STEPS)), strict=True)]
    yield Row(f"smoothing, a step of {STEPS[1]}", times_us[1], f"of {STEPS[0]}", times_us[0], at_least=0.5)


def _smoothing(steps: int) -> Callable[[], object]:
    rng = np.random.default_rng(9)
    evidence, xy_m, heading_rad = list[Step | RadioFix](), np.zeros(2), 0.0
    for number in range(steps):
        heading_rad += 0.02
        xy_m = xy_m + 0.7 * np.array([np.sin(heading_rad), np.cos(heading_rad)])
        evidence.append(Step(0.5 * number, 0.5, 0.7, wrap(heading_rad), 0.2, 0.02, np.nan))
        if number % 4 == 0:
            seen_m = xy_m + rng.normal(0.0, 3.0, 2)
            evidence.append(RadioFix(0.5 * number, "F1", seen_m, 6.0 * np.eye(2), 3.0, 0.1, fits=True))
    moments = [Moment(0.5 * number, Motion.WALKING) for number in range(0, steps, 2)]
    return lambda: smoothed(evidence, moments)
