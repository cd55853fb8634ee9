"""What months do to a building's access points: some are replaced, some moved, some send with another power.

Each access point has its own time for each of the three, drawn once: what has changed after three months has changed
after six. The rates are assumed; docs/simulation.md says so.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.simulation.access_points import (
    LONG_SHADOWING_M,
    SHORT_SHADOWING_M,
    AccessPoints,
)
from app.simulation.random_field import RandomField

REPLACED_A_MONTH, MOVED_A_MONTH, POWER_A_MONTH = 0.015, 0.005, 0.015
"""Shares of those not yet changed that change within a month."""
MOVED_BY_M = 12.0
POWER_BY_DB = 6.0
_ADDRESS_BITS = 24
"""Of an address those that a maker numbers its devices with."""


@dataclass(frozen=True, slots=True, eq=False)
class Aged:
    """Access points after some months. changed : share of them that differ in any way from the first day."""

    access_points: AccessPoints
    changed: float


def aged(access_points: AccessPoints, months: float, seed: int) -> Aged:
    """The access points so many months later; radios at one place are one access point and change together.

    Parameters
    ----------
    seed : of the building's fate; the same seed with more months is the same building later.
    """
    fate_rng, radio_rng = np.random.default_rng([seed, 6]).spawn(2)
    _, unit = np.unique(access_points.place_m, axis=0, return_inverse=True)
    unit = unit.reshape(-1)
    count = int(unit.max()) + 1
    rates = np.array([REPLACED_A_MONTH, MOVED_A_MONTH, POWER_A_MONTH])
    month = fate_rng.exponential(-1.0 / np.log1p(-rates), (count, 3))
    replaced, moved, louder = (month <= months).T
    number = fate_rng.integers(1, 1 << _ADDRESS_BITS, count)
    step_m = fate_rng.normal(0.0, MOVED_BY_M, (count, 2))
    power_db = fate_rng.normal(0.0, POWER_BY_DB, count)

    place_m = access_points.place_m.copy()
    place_m[:, :2] += np.where(moved[:, np.newaxis], step_m, 0.0)[unit]
    unit_of_network = unit[access_points.radio]
    bssid = np.where(replaced[unit_of_network], access_points.bssid ^ number[unit_of_network], access_points.bssid)
    long_field, short_field = (
        _redrawn(field, np.flatnonzero(moved[unit]), length_m, radio_rng)
        for field, length_m in (
            (access_points.long_shadowing, LONG_SHADOWING_M),
            (access_points.short_shadowing, SHORT_SHADOWING_M),
        )
    )
    later = replace(
        access_points,
        place_m=place_m,
        level_at_1m_dbm=access_points.level_at_1m_dbm + np.where(louder, power_db, 0.0)[unit],
        bssid=bssid,
        long_shadowing=long_field,
        short_shadowing=short_field,
    )
    return Aged(later, float(np.mean(replaced | moved | louder)))


def _redrawn(field: RandomField, radios: IntArray, length_m: float, rng: np.random.Generator) -> RandomField:
    """The field with new values for radios that hang elsewhere. All are drawn, so that a radio's do not depend on
    which others moved."""
    new = RandomField.draw(rng, len(field.wave_radpm), field.sigma, length_m)
    wave: FloatArray = field.wave_radpm.copy()
    phase: FloatArray = field.phase_rad.copy()
    wave[radios], phase[radios] = new.wave_radpm[radios], new.phase_rad[radios]
    return replace(field, wave_radpm=wave, phase_rad=phase)
