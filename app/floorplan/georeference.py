"""The local metric frame of a floor and WGS 84."""

from __future__ import annotations

import math
from dataclasses import dataclass

METRES_PER_DEGREE = 111319.49
"""Length of a degree of latitude, and of longitude at the equator, on the sphere that floor frames are laid out on."""


@dataclass(frozen=True, slots=True)
class Georeference:
    """Where the origin of a floor's frame lies.

    latitude_deg, longitude_deg : WGS 84, of the origin.  rotation_rad : of the frame's y axis, clockwise from north.
    """

    latitude_deg: float
    longitude_deg: float
    rotation_rad: float

    def to_wgs84(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Latitude and longitude in degrees of a point of the frame (equirectangular about the origin)."""
        c, s = math.cos(self.rotation_rad), math.sin(self.rotation_rad)
        east, north = c * x_m + s * y_m, -s * x_m + c * y_m
        scale = METRES_PER_DEGREE * math.cos(math.radians(self.latitude_deg))
        return self.latitude_deg + north / METRES_PER_DEGREE, self.longitude_deg + east / scale

    def to_local(self, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
        """x, y in metres of a WGS 84 point; the inverse of to_wgs84."""
        scale = METRES_PER_DEGREE * math.cos(math.radians(self.latitude_deg))
        east = (longitude_deg - self.longitude_deg) * scale
        north = (latitude_deg - self.latitude_deg) * METRES_PER_DEGREE
        c, s = math.cos(self.rotation_rad), math.sin(self.rotation_rad)
        return c * east - s * north, s * east + c * north
