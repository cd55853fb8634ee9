"""Which readings of a scan are fresh, and when a scan only repeats another."""

from __future__ import annotations

import numpy as np
import pytest

from app.observations import WifiScan
from app.wifi.readings import FRESH_S, fresh_readings, is_news


def scan(*age_s: float) -> WifiScan:
    count = len(age_s)
    return WifiScan(100.0, np.arange(count), np.full(count, -60.0), 100.0 - np.array(age_s, np.float64))


def test_what_was_heard_long_before_is_not_fresh() -> None:
    assert fresh_readings(scan(0.0, FRESH_S, FRESH_S + 0.1)).bssid.tolist() == [0, 1]


@pytest.mark.parametrize(
    ("age_s", "news"),
    [((0.2, 0.2, 0.2), True), ((3.0, 3.0, 0.2), False), ((3.0, 0.2), True), ((30.0, 30.0, 0.2), True)],
)
def test_a_scan_is_news_if_half_of_what_is_fresh_was_heard_since(age_s: tuple[float, ...], news: bool) -> None:
    assert is_news(scan(*age_s), 98.0) is news


def test_the_first_scan_is_news() -> None:
    assert is_news(scan(5.0), None)
