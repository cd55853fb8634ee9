"""The rows beside the methods are what their names say."""

from __future__ import annotations

import numpy as np
import pytest

from app.evaluation.alone import ALONE, ROWS, WIFI_ALONE, by_name
from app.fusion.methods import METHODS
from tests.fusion.walks import deaf, errors_m, places_m, run, walked

WALK = walked(5)


def test_every_row_has_its_own_name() -> None:
    assert set(ALONE).isdisjoint(METHODS)
    assert all(method.method == name for name, method in ROWS.items())


def test_a_second_row_of_one_name_is_refused() -> None:
    with pytest.raises(ValueError, match="wifi_alone"):
        by_name((*METHODS.values(), WIFI_ALONE, WIFI_ALONE))


def test_wifi_alone_stays_where_the_last_scan_was() -> None:
    fixes = run(ALONE["wifi_alone"], WALK.batches)
    moved = [not np.array_equal(one, other) for one, other in zip(places_m(fixes), places_m(fixes)[1:], strict=False)]
    scans = sum(bool(batch.wifi) for batch in WALK.batches)
    assert 0.5 * scans < sum(moved) < scans


def test_dead_reckoning_alone_begins_at_the_first_scan_and_hears_no_other() -> None:
    first = next(number for number, batch in enumerate(WALK.batches) if batch.wifi)
    silent = [batch if number <= first else deaf(batch) for number, batch in enumerate(WALK.batches)]
    hearing, deafened = (places_m(run(ALONE["pdr_alone"], batches)) for batches in (WALK.batches, silent))
    assert np.abs(hearing - deafened).max() < 0.01


def test_fused_is_better_than_either_alone() -> None:
    errors: dict[str, list[float]] = {name: [] for name in ("integrity_ukf", "wifi_alone", "pdr_alone")}
    for seed in (0, 1, 2, 4, 5):
        for name in errors:
            walk = walked(seed)
            errors[name] += errors_m(walk, run(ROWS[name], walk.batches)).tolist()
    mean = {name: np.mean(found) for name, found in errors.items()}
    assert mean["integrity_ukf"] < mean["wifi_alone"]
    assert mean["integrity_ukf"] < mean["pdr_alone"]
