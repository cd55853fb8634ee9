"""Smooth random functions of place: shadowing of access points, magnetic disturbances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray, IntArray

FEATURES = 32
"""Cosines per field: enough that values look normal."""


@dataclass(frozen=True, slots=True, eq=False)
class RandomField:
    """Several independent Gaussian fields over space, each a sum of random cosines (random Fourier features of a
    Matérn kernel with smoothness 1, which is as rough as measured shadowing).

    wave_radpm : (fields, FEATURES, 3).  phase_rad : (fields, FEATURES).  sigma : standard deviation of the values.
    """

    wave_radpm: FloatArray
    phase_rad: FloatArray
    sigma: float

    @classmethod
    def draw(cls, rng: np.random.Generator, fields: int, sigma: float, length_m: float) -> RandomField:
        """Fields whose values are alike over about length_m."""
        wave = rng.normal(0.0, 1.0 / length_m, (fields, FEATURES, 3))
        wave /= np.sqrt(rng.chisquare(2.0, (fields, FEATURES, 1)) / 2.0)
        return cls(wave, rng.uniform(-np.pi, np.pi, (fields, FEATURES)), sigma)

    def at(self, fields: IntArray, xyz_m: FloatArray) -> FloatArray:
        """Value (n,) of the named field (n,) at each place (n, 3)."""
        angle = np.einsum("nfd,nd->nf", self.wave_radpm[fields], xyz_m) + self.phase_rad[fields]
        return np.asarray(self.sigma * np.sqrt(2.0 / FEATURES) * np.cos(angle).sum(axis=1), dtype=np.float64)

    def all_at(self, xyz_m: FloatArray) -> FloatArray:
        """Value (n, fields) of every field at each place (n, 3)."""
        angle = np.einsum("kfd,nd->nkf", self.wave_radpm, xyz_m) + self.phase_rad
        return np.asarray(self.sigma * np.sqrt(2.0 / FEATURES) * np.cos(angle).sum(axis=2), dtype=np.float64)
