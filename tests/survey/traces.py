"""Traces made for tests: a straight walk along x with steps, scans and waypoints."""

from __future__ import annotations

import math

START_MS = 1_574_559_495_000
BRAND = "OPPO"
UUID = "9195B3AD-A9D0-4500-85FF-9FB0F65A5201"


def mac(number: int) -> str:
    """`02:00:00:00:00:07` of 7."""
    return ":".join(f"{0x020000000000 + number:012x}"[at : at + 2] for at in range(0, 12, 2))


def wifi(t: int, number: int, rssi: float, seen: int | None = None, ssid: str = "shop") -> str:
    """One reading."""
    return f"{t}\tTYPE_WIFI\t{ssid}\t{mac(number)}\t{rssi}\t2412\t{t if seen is None else seen}"


def beacon(t: int, minor: int, rssi: float, major: int = 7, address: str = "E0:78:A3:3D:B5:D6") -> str:
    """One reading of a Bluetooth beacon."""
    return f"{t}\tTYPE_BEACON\t{UUID}\t{major}\t{minor}\t-56\t{rssi}\t45.03\t{address}\t{t}"


def waypoint(t: int, x: float, y: float) -> str:
    """Where the surveyor stood."""
    return f"{t}\tTYPE_WAYPOINT\t{x}\t{y}"


def acceleration(t: int, z: float) -> str:
    """A sample of a phone that lies flat."""
    return f"{t}\tTYPE_ACCELEROMETER\t0.0\t0.0\t{z:.4f}\t3"


def trace(*lines: str) -> bytes:
    """The lines of a trace, under a header."""
    header = [f"#\tstartTime:{START_MS}", f"#\tBrand:{BRAND}\tModel:PBCM10\tAndroidName:8.1.0\t"]
    return ("\n".join([*header, *lines]) + "\n").encode()


def walk(seconds: int = 20, access_points: int = 6, x_m: float = 1.0, y_m: float = 5.0) -> bytes:
    """A walk at one metre a second along x, a scan every two seconds, a waypoint every ten."""
    records = []
    for tick in range(50 * seconds + 1):
        t = START_MS + 20 * tick
        records.append((t, acceleration(t, 9.81 + 3.0 * math.sin(2.0 * math.pi * 1.8 * tick / 50))))
    for second in range(0, seconds + 1, 2):
        t = START_MS + 1000 * second
        records += [(t, wifi(t, n, -40 - n - second, t - 500)) for n in range(access_points)]
    for second in range(0, seconds + 1, 10):
        t = START_MS + 1000 * second
        records.append((t, waypoint(t, x_m + second, y_m)))
    return trace(*(line for _, line in sorted(records, key=lambda one: one[0])))
