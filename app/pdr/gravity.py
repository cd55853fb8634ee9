"""What an accelerometer at rest shows."""

from __future__ import annotations

GRAVITY_MPS2 = 9.80665
"""The standard one, upwards."""
