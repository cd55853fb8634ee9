from __future__ import annotations

import math
import statistics

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.evaluation.replay import Answer
from app.evaluation.scoring import ISO_18305, Errors, Score, errors_of, quantile, score
from app.observations import Flag
from tests.evaluation.answers import answer

answers = st.lists(
    st.builds(
        lambda error_m, floor_right, waypoint, covered, scanned, usable, level_m, flag, walk: answer(
            error_m,
            floor_right=floor_right and error_m is not None,
            waypoint=waypoint,
            covered=covered,
            scanned=scanned,
            usable=usable,
            protection_level_m=None if error_m is None else level_m,
            accuracy_m=None if error_m is None else level_m / 3,
            flag=flag,
            walk=walk,
        ),
        error_m=st.none() | st.floats(0, 100),
        floor_right=st.booleans(),
        waypoint=st.booleans(),
        covered=st.booleans(),
        scanned=st.booleans(),
        usable=st.booleans(),
        level_m=st.floats(0.1, 50),
        flag=st.sampled_from(list(Flag)),
        walk=st.sampled_from(["one", "two", "three"]),
    ),
    max_size=40,
)


@given(answers)
def test_the_figures_are_those_of_their_plain_formulas(records: list[Answer]) -> None:
    result = score(records)
    placed = [r for r in records if r.error_m is not None]
    off_m = {id(r): r.error_m if r.error_m is not None and r.floor_right else math.inf for r in records}
    level_m = {id(r): r.protection_level_m or 0.0 for r in records}
    beyond_level = [off_m[id(r)] > level_m[id(r)] for r in placed]
    beyond_radius = [off_m[id(r)] > (r.accuracy_m or 0.0) for r in placed]
    hazardous = [r for r in records if r.usable and off_m[id(r)] > 10.0]
    misleading = [r for r in records if r.usable and off_m[id(r)] > level_m[id(r)]]
    at_covered = [r.error_m for r in records if r.error_m is not None and r.waypoint and r.covered]
    first_scan_on = [r for r in records if r.scanned]
    expected = {
        "positioned": (len(placed), len(records)),
        "positioned_after_first_scan": (sum(r.error_m is not None for r in first_scan_on), len(first_scan_on)),
        "floor_right": (sum(r.floor_right for r in placed), len(placed)),
        "inside_68": (beyond_radius.count(False), len(placed)),
        "inside_protection_level": (beyond_level.count(False), len(placed)),
        "available": (sum(r.usable for r in records), len(records)),
        "available_covered": (
            sum(r.usable for r in first_scan_on if r.covered),
            sum(r.covered for r in first_scan_on),
        ),
        "misleading": (len(misleading), len(records)),
        "hazardous": (len(hazardous), len(records)),
        "walks_with_fault_flag": (
            len({r.walk for r in records if r.flag is Flag.FAULT}),
            len({r.walk for r in records}),
        ),
    }
    for name, (part, whole) in expected.items():
        value = getattr(result, name)
        assert value == part / whole if whole else math.isnan(value), name
    assert result.waypoints_covered.n == len(at_covered)
    if at_covered:
        assert result.waypoints_covered.mean_m == pytest.approx(sum(at_covered) / len(at_covered))
        assert result.waypoints_covered.rms_m == pytest.approx(
            math.sqrt(sum(e * e for e in at_covered) / len(at_covered))
        )
    assert sum(result.flags.values()) == len(records)


def test_a_wrong_floor_is_outside_of_every_radius() -> None:
    result = score([answer(0.5, floor_right=False), answer(0.5)])
    assert (result.inside_68, result.inside_protection_level) == (0.5, 0.5)
    assert (result.hazardous, result.misleading) == (0.5, 0.5)


def test_an_unusable_answer_is_never_hazardous_however_wrong() -> None:
    result = score([answer(50.0, usable=False)])
    assert (result.hazardous, result.misleading, result.available) == (0.0, 0.0, 0.0)


def test_an_error_equal_to_the_radius_is_inside() -> None:
    assert score([answer(2.0)]).inside_68 == 1.0


def test_a_walk_of_the_same_name_in_another_fold_or_floor_is_another_walk() -> None:
    assert score([answer(), answer(fold=1), answer(floor="F2")]).walks == 3


@given(st.lists(st.floats(0, 1e6), min_size=1), st.floats(0, 1))
def test_a_quantile_is_one_of_the_values_and_no_interpolation(values: list[float], q: float) -> None:
    ordered = sorted(values)
    assert quantile(values, q) == ordered[min(int(q * len(values)), len(values) - 1)]


def test_nothing_scores_nan_and_not_zero() -> None:
    empty = score([])
    assert empty.walks == empty.waypoints.n == 0
    assert all(
        math.isnan(v) for v in (empty.positioned, empty.hazardous, empty.every_answer.mean_m, empty.batch_ms_p50)
    )


def test_the_level_is_correlated_with_the_error() -> None:
    errors, levels = [1.0, 2.0, 4.0, 3.0], [5.0, 6.0, 8.0, 9.0]
    result = score([answer(e, protection_level_m=level) for e, level in zip(errors, levels, strict=True)])
    assert result.level_error_correlation == pytest.approx(statistics.correlation(levels, errors))


def test_every_name_of_the_standard_belongs_to_a_figure_that_exists() -> None:
    assert set(ISO_18305) <= {*Errors.__dataclass_fields__, *Score.__dataclass_fields__}


def test_errors_of_one_value_are_that_value() -> None:
    assert errors_of([3.0]) == Errors(1, 3.0, 3.0, 3.0, 3.0, 3.0)
