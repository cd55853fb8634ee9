"""What a phone reports of the radio around it, the way Android does.

A scan takes about two seconds and visits one channel after the other, so its readings are of different places when the
phone moves. Beacons are missed, the weaker the likelier. What was heard within the last half minute is reported again
with its old level and old time. That is where the open data's stale readings come from, and it is kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.simulation.access_points import AccessPoints
from app.simulation.walker import Walk

FADING_DB, FADING_M = 2.5, 0.4
"""Multipath: the same while the phone rests, another after a step, shared by the networks of one radio."""
NETWORK_JITTER_DB = 0.8
HAND_WALK_DB, HAND_DB = 2.4, 2.1
"""How a phone is held shifts all levels alike, from walk to walk and along the way."""
HEARING_DBM, HEARING_WIDTH_DB, DEAF_BELOW_DBM = -81.0, 3.0, -91.5
"""Where half the beacons are missed, how fast that changes, and what is never heard."""
BODY_LOSS_DB = 9.0
"""Of a signal from straight behind the person who holds the phone."""
CHANGED_DB = 2.2
"""Each radio's change between two visits: doors, goods, people, transmit power control."""
SWITCHED_OFF = 0.04
KEPT_S = 30.0
USUAL_PAUSE_S = 2.15
PREROLL_S = 24.0
"""The phone has been scanning for so long when the walk begins."""
DUPLICATE = 0.005


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedScan:
    """One delivered scan. network : (n,) index into AccessPoints.bssid, repeated where Android repeats itself.
    rssi_dbm : (n,) integers.  seen_ms : (n,) integers, up to half a minute before time_ms."""

    time_ms: int
    network: IntArray
    rssi_dbm: IntArray
    seen_ms: IntArray


def scans_along(
    walk: Walk,
    access_points: AccessPoints,
    offset_db: float,
    rng: np.random.Generator,
    every_s: float | None = None,
    unrest: float = 1.0,
) -> Iterator[SimulatedScan]:
    """The scans delivered during a walk, one every 2 to 4 s, made as they are asked for.

    offset_db : what this phone reads more than another.  every_s : of a phone that scans so often, and as much faster.
    unrest : by what fading and the changes between two visits are larger than usual.
    """
    radios = len(access_points.level)
    changed_db = rng.normal(0.0, unrest * CHANGED_DB, radios) + offset_db + rng.normal(0.0, HAND_WALK_DB)
    changed_db[rng.random(radios) < SWITCHED_OFF] = -200.0
    networks = len(access_points.bssid)
    seen_s = np.full(networks, -np.inf)
    rssi = np.zeros(networks, dtype=np.int64)
    channel_age_s = np.where(
        access_points.frequency_mhz < 4000,
        1.95 - (access_points.frequency_mhz - 2412) / 50 * 0.65,
        1.15 - (access_points.frequency_mhz - 5180) / 645 * 0.45,
    )
    channel_age_s *= 1.0 if every_s is None else min(every_s / USUAL_PAUSE_S, 1.0)
    fading_db, moved_m = unrest * _fading_db(rng, radios), 0.0
    time_s = walk.time_s[0] - PREROLL_S + float(rng.uniform(0.0, 2.0))
    while time_s <= walk.time_s[-1]:
        heard_s = time_s - channel_age_s - rng.uniform(0.0, 0.08, radios)
        heard, level = _listen(walk, access_points, heard_s)
        alike = np.exp(-moved_m / FADING_M)
        fading_db = alike * fading_db + np.sqrt(1.0 - alike**2) * unrest * _fading_db(rng, radios)
        of_radio = np.full(radios, -200.0)
        of_radio[heard] = level + (changed_db + fading_db)[heard]
        heard_level = of_radio[access_points.radio] + rng.normal(0.0, NETWORK_JITTER_DB, networks)
        missed_by = (HEARING_DBM - heard_level) / HEARING_WIDTH_DB
        caught = rng.random(networks) < 0.93 / (1.0 + np.exp(np.clip(missed_by, -50.0, 50.0)))
        caught &= heard_level > DEAF_BELOW_DBM
        before_s, before = seen_s[caught], rssi[caught]
        seen_s[caught], rssi[caught] = heard_s[access_points.radio[caught]], np.rint(heard_level[caught]).astype(int)
        if time_s >= walk.time_s[0]:
            listed = np.flatnonzero(time_s - seen_s < KEPT_S)
            twice = (rng.random(len(before)) < DUPLICATE) & (time_s - before_s < KEPT_S)
            network = np.concatenate([listed, np.flatnonzero(caught)[twice]])
            values = np.concatenate([rssi[listed], before[twice]])
            seen = np.concatenate([seen_s[listed], before_s[twice]])
            order = np.argsort(-values, kind="stable")
            if len(order):
                yield SimulatedScan(
                    round(1000 * time_s), network[order], values[order], np.rint(1000 * seen[order]).astype(np.int64)
                )
        earlier_s, time_s = time_s, time_s + (_pause_s(rng) if every_s is None else every_s)
        moved_m = walk.moved_m(earlier_s, time_s)


def _listen(walk: Walk, access_points: AccessPoints, heard_s: FloatArray) -> tuple[IntArray, FloatArray]:
    """Radios that may be heard at their times, and the levels at which they arrive."""
    xy = np.column_stack([np.interp(heard_s, walk.time_s, walk.xy_m[:, axis]) for axis in (0, 1)])
    heard, level = access_points.mean_dbm(walk.floor_at(float(heard_s[0])), xy)
    away = access_points.place_m[heard, :2] - xy[heard]
    bearing = np.arctan2(away[:, 0], away[:, 1])
    facing = np.interp(heard_s[heard], walk.time_s, walk.heading_rad)
    behind = 0.5 * (1.0 - np.cos(bearing - facing))
    return heard, level - BODY_LOSS_DB * behind


def _fading_db(rng: np.random.Generator, radios: int) -> FloatArray:
    return rng.normal(0.0, FADING_DB, radios) + rng.normal(0.0, HAND_DB)


def _pause_s(rng: np.random.Generator) -> float:
    kind = rng.random()
    if kind < 0.003:
        return float(rng.uniform(10.0, 20.0))  # the radio was busy elsewhere
    if kind < 0.06:
        return float(rng.uniform(3.0, 6.0))
    return float(rng.normal(USUAL_PAUSE_S, 0.15))
