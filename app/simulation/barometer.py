"""What a phone's barometer reads: the height of the walker, the weather, and the sensor's noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray
from app.observations import PressureSamples
from app.simulation.imu import wander
from app.simulation.walker import Walk

RATE_HZ = 5.0
HPA_PER_M = 0.12
"""Near the ground."""
DRAUGHT_HPA, DRAUGHT_S = 0.02, 20.0
"""Doors, wind and ventilation."""


@dataclass(frozen=True, slots=True)
class Weather:
    """ground_hpa : at the ground floor.  drift_hpa_per_h : how it changes.  noise_hpa : of one sample of the sensor.
    draught_hpa : of what comes and goes in the building."""

    ground_hpa: float = 1013.0
    drift_hpa_per_h: float = 0.0
    noise_hpa: float = 0.05
    draught_hpa: float = DRAUGHT_HPA

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Weather:
        """Some day, and some phone."""
        return cls(float(rng.uniform(985.0, 1030.0)), float(rng.uniform(-1.0, 1.0)), float(rng.uniform(0.03, 0.1)))


def pressures(walk: Walk, weather: Weather, rng: np.random.Generator) -> PressureSamples:
    """The samples of a walk, RATE_HZ of them a second."""
    time_s: FloatArray = np.arange(walk.time_s[0], walk.time_s[-1], 1.0 / RATE_HZ)
    height_m: FloatArray = np.interp(time_s, walk.time_s, walk.height_m)
    pressure_hpa = weather.ground_hpa - HPA_PER_M * height_m
    pressure_hpa += weather.drift_hpa_per_h * (time_s - time_s[0]) / 3600.0
    pressure_hpa += wander(rng, len(time_s), DRAUGHT_S * RATE_HZ, weather.draught_hpa)
    pressure_hpa += rng.normal(0.0, weather.noise_hpa, len(time_s))
    return PressureSamples(np.round(time_s, 3), pressure_hpa)
