from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.fusion.fix_assembly import Estimate, Phases, Walker, assembled_fix
from app.fusion.interface import SessionStart
from app.observations import Carrying, Motion, Position

radii_m = st.floats(0.1, 100.0)


@given(
    st.none() | radii_m,
    st.none() | radii_m,
    st.floats(0.01, 900.0),
    st.floats(1.0, 60.0),
    st.integers(0, 1),
)
def test_a_fix_is_usable_exactly_if_the_level_that_it_tells_is_within_the_alert_limit_and_nothing_is_at_fault(
    accuracy_m: float | None, level_m: float | None, variance_m2: float, limit_m: float, fault: int
) -> None:
    estimate = Estimate(Position(1.0, 2.0, "F1"), variance_m2 * np.eye(2), accuracy_m=accuracy_m, level_m=level_m)
    walker = Walker(None, None, 0, Motion.STILL, Carrying.UNKNOWN)
    start, phases = SessionStart(alert_limit_m=limit_m), Phases(if3=fault)
    fix = assembled_fix(start, 0.0, estimate, walker, phases, False, ())
    told = fix.integrity.protection_level_m
    assert told is not None and fix.accuracy_m is not None and told >= fix.accuracy_m
    assert fix.integrity.usable == (not fault and told <= limit_m)
    assert level_m is None or told == pytest.approx(max(level_m, fix.accuracy_m))
