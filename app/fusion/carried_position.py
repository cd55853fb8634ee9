"""The second filter of method C: moved by a step with its own noises, measured by a kernel-density fix near by."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from app.estimation.arrays import FloatArray
from app.estimation.extended_kalman import predict_covariance
from app.fusion import walking_ukf as ukf
from app.fusion.carried_steps import CarriedStep
from app.fusion.dual_settings import DualSettings, Filter
from app.fusion.walking_track import Track
from app.observations import WifiScan
from app.wifi.kernel_matching import kernel_match
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap
from app.wifi.readings import fresh_readings


def moved_on(track: Track, one: CarriedStep, settings: DualSettings) -> Track:
    """The track after a step, Eq. 38-42. One whose heading is unknown goes nowhere, but gets less certain by a step.

    The variance of its heading stands in the track's covariance already; the transform takes it to the position. The
    extended and the linear filter put a line, or nothing, in the transform's place.
    """
    step, own = one.step, settings.track
    size, kept = len(track.mean), math.exp(-one.step.length_m / own.bias_reach_m)
    empirical = settings.empirical
    length_sigma_m = one.length_sigma_m if empirical is None else empirical.length_m
    noise = np.zeros(size)
    noise[:2] = length_sigma_m**2
    if size > ukf.PLAIN:
        noise[ukf.LOG_SCALE], noise[ukf.ASKEW] = own.scale_drift**2, own.askew_drift_rad**2
        noise[ukf.WIFI_X :] = track.bias_variance_m2 * (1.0 - kept * kept)
    mean, covariance = track.mean, track.covariance
    length_m = step.length_m
    if not track.headed:
        noise[:2] += own.lost_share * step.length_m**2
        length_m = 0.0
    elif empirical is not None:
        covariance = covariance.copy()
        covariance[ukf.HEADING, ukf.HEADING] += empirical.heading_rad**2 - one.heading_variance
    if settings.position_filter is Filter.UNSCENTED:
        mean, covariance = ukf.predict(mean, covariance, length_m, 0.0, 0.0, kept, noise, own.alpha)
    else:
        mean, covariance = _without_sigma_points(mean, covariance, length_m, kept, noise, settings)
    return replace(track, mean=mean, covariance=covariance, stride_m=step.length_m, stride_s=step.duration_s)


def _without_sigma_points(
    mean: FloatArray, covariance: FloatArray, length_m: float, kept: float, noise: FloatArray, settings: DualSettings
) -> tuple[FloatArray, FloatArray]:
    """The extended filter's step; the linear one's takes length and heading for certain, and the noise for all else."""
    size, transition = len(mean), np.eye(len(mean))
    scale = math.exp(float(mean[ukf.LOG_SCALE])) if size > ukf.PLAIN else 1.0
    east_m, north_m = (scale * length_m * f(float(mean[ukf.HEADING])) for f in (math.sin, math.cos))
    if settings.position_filter is Filter.EXTENDED:
        transition[0, ukf.HEADING], transition[1, ukf.HEADING] = north_m, -east_m
        if size > ukf.PLAIN:
            transition[0, ukf.LOG_SCALE], transition[1, ukf.LOG_SCALE] = east_m, north_m
    elif settings.empirical is not None:
        noise[:2] += (length_m * settings.empirical.heading_rad) ** 2 / 2.0
    mean = mean.copy()
    mean[:2] += [east_m, north_m]
    if size > ukf.PLAIN:
        mean[ukf.WIFI_X :] *= kept
        transition[ukf.WIFI_X, ukf.WIFI_X] = transition[ukf.WIFI_Y, ukf.WIFI_Y] = kept
    return mean, predict_covariance(covariance, transition, np.diag(noise))


def area_match(
    radio_map: RadioMap, scan: WifiScan, floor: str | None, inside: Track | None, settings: DualSettings
) -> Match | None:
    """Place of a scan's fresh readings among the reference points near the track, Eq. 32-37.

    Parameters
    ----------
    floor : name of the floor to place it on; None: the one that it sounds most like.
    inside : whose surroundings are looked at; None: everywhere.

    Returns
    -------
    None where the scan says too little.

    Notes
    -----
    Differs from the paper: where the scan is far more like some place outside the trusted area than like any inside,
    the fix is that place, for the position filter to test: one that only looks around itself never learns that it is
    lost.
    """
    fresh = fresh_readings(scan)
    where = radio_map.floors.index(floor) if floor in radio_map.floors else None
    everywhere = kernel_match(radio_map, fresh.bssid, fresh.rssi_dbm, settings.kernel, floor=where)
    if everywhere is None or everywhere.known < settings.least_known:
        return None
    if inside is None or where is None:
        return everywhere
    sigma_m = math.sqrt(float(np.trace(inside.covariance[:2, :2])) / 2.0)
    radius_m = settings.area.least_m + settings.area.sigmas * sigma_m
    apart_m2 = ((radio_map.xy_m - inside.mean[:2]) ** 2).sum(axis=1)
    points = np.flatnonzero((radio_map.floor == where) & (apart_m2 <= radius_m**2))
    near = kernel_match(radio_map, fresh.bssid, fresh.rssi_dbm, settings.kernel, floor=where, points=points)
    if near is None or near.signal_distance > settings.area.elsewhere * everywhere.signal_distance:
        return everywhere
    return near
