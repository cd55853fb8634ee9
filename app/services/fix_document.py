"""A Fix as the document that phones get: exactly the fields of the contract, and never a number that is not finite.

It is stored as it was answered; what of it is asked often is read here without parsing it.
"""

from __future__ import annotations

import math
import re
from typing import Any

import orjson

from app.fusion.fix_assembly import Walker, no_fix
from app.fusion.interface import SessionStart, Site
from app.observations import Batch, Carrying, Excluded, Fix, Flag, Integrity, Motion, Position
from app.wifi.bssid import format_bssid

_BEFORE_THE_FIRST = Batch(sequence=-1, end_s=None)
_NOBODY = Walker(None, None, 0, Motion.UNKNOWN, Carrying.UNKNOWN)
_FLAG = re.compile(rb'"flag":"([a-z]+)"')


def fix_document(session: str, batch: Batch, fix: Fix, site: Site) -> bytes:
    """The answer to a batch, as JSON.

    Raises
    ------
    ValueError : the method broke its promise: a number that is not finite, a position without a radius.
    """
    return orjson.dumps(
        {
            "session": session,
            "sequence": batch.sequence,
            "t": None if fix.time_s is None else round(1000.0 * _finite("t", fix.time_s)),
            "dropped": batch.dropped,
            "gap": batch.gap,
            **_estimate(fix, site),
            "steps": int(fix.step_count),
            "motion": fix.motion.value,
            "carrying": fix.carrying.value,
            "integrity": _integrity(fix.integrity, positioned=fix.position is not None),
        }
    )


def initial_document(session: str, alert_limit_m: float, risk: float) -> bytes:
    """What a session answers before its first batch: sequence -1, nothing known."""
    fix = no_fix(SessionStart(alert_limit_m, risk), None, _NOBODY)
    return fix_document(session, _BEFORE_THE_FIRST, fix, Site())


def position_document(position: Position, site: Site) -> dict[str, Any]:
    """A place in its floor's frame and, where that has a georeference, in WGS 84.

    Raises
    ------
    ValueError : a number is not finite.
    """
    x_m, y_m = _finite("x", position.x_m), _finite("y", position.y_m)
    floor = site.floors.get(position.floor)
    georeference = None if floor is None else floor.georeference
    latitude, longitude = (None, None) if georeference is None else georeference.to_wgs84(x_m, y_m)
    return {
        "x": x_m,
        "y": y_m,
        "floor": position.floor,
        "latitude": None if latitude is None else _finite("latitude", latitude),
        "longitude": None if longitude is None else _finite("longitude", longitude),
    }


def flag_of(fix: bytes) -> Flag:
    """The flag of a stored Fix. Quotation marks within text are escaped, so what reads like a flag is one."""
    found = _FLAG.search(fix)
    assert found is not None  # every Fix has one
    return Flag(found[1].decode())


def in_fault(fix: bytes | None) -> bool:
    """Whether a stored Fix is in fault; no Fix is not."""
    return fix is not None and flag_of(fix) is Flag.FAULT


def _estimate(fix: Fix, site: Site) -> dict[str, Any]:
    if fix.position is None:
        return dict.fromkeys(("position", "accuracy", "covariance", "heading", "speed"))
    if fix.covariance_m2 is None:
        raise ValueError("a position without covariance")
    return {
        "position": position_document(fix.position, site),
        "accuracy": _radius("accuracy", fix.accuracy_m),
        "covariance": [[_finite("covariance", value) for value in row] for row in fix.covariance_m2],
        # where a phone is may be known while where it is going is not yet
        "heading": None if fix.heading_rad is None else _finite("heading", fix.heading_rad),
        "speed": None if fix.speed_mps is None else _finite("speed", fix.speed_mps),
    }


def _integrity(integrity: Integrity, positioned: bool) -> dict[str, Any]:
    return {
        "flag": integrity.flag.value,
        "usable": bool(integrity.usable and positioned),
        "if1": int(integrity.if1),
        "if2": int(integrity.if2),
        "if3": int(integrity.if3),
        "statistic": None if integrity.statistic is None else _finite("statistic", integrity.statistic),
        "threshold": None if integrity.threshold is None else _finite("threshold", integrity.threshold),
        "protection_level": _radius("protection_level", integrity.protection_level_m) if positioned else None,
        "alert_limit": _finite("alert_limit", integrity.alert_limit_m),
        "risk": _finite("risk", integrity.risk),
        "excluded": [_excluded(one) for one in integrity.excluded],
    }


def _excluded(one: Excluded) -> dict[str, str]:
    if one.bssid is not None:
        return {"bssid": format_bssid(one.bssid), "reason": one.reason}
    return {"observation": one.observation or "", "reason": one.reason}


def _radius(name: str, value: float | None) -> float:
    if value is None or _finite(name, value) <= 0.0:
        raise ValueError(f"{name} of a position must be positive, not {value}")
    return float(value)


def _finite(name: str, value: float) -> float:
    if not math.isfinite(value):
        raise ValueError(f"{name} of a Fix is {value}")
    return float(value)
