from __future__ import annotations

import lzma
from pathlib import Path

import numpy as np
import pytest

from app.errors import InvalidInput
from app.evaluation.trust_rows import RISKS
from app.evaluation.two_surveys import CASES, Standing, read_standing, two_surveys
from app.fusion.surefix import SUREFIX
from app.observations import WifiScan
from tests.odometer import ODOMETER
from tests.open_data import open_data

POINTS, SCANS = 14, 4


def _survey(shift_db: float) -> list[Standing]:
    """Scans every 3 m along a corridor with five access points."""
    found, rng = list[Standing](), np.random.default_rng(3)
    for point in range(POINTS):
        xy_m = np.array([3.0 * point, 0.0])
        for number in range(SCANS):
            away_m = np.abs(np.linspace(0.0, 40.0, 5) - xy_m[0])
            rssi_dbm = np.round(-40.0 - 1.2 * away_m + shift_db + rng.normal(0.0, 0.5, 5))
            time_s = 1e9 + 100.0 * point + number
            found.append(Standing(point, xy_m, WifiScan(time_s, np.arange(1, 6), rssi_dbm, np.full(5, time_s))))
    return found


def test_every_scan_that_is_asked_is_answered_once() -> None:
    reported: list[int] = []
    found = two_surveys(_survey(0.0), _survey(-3.0), ODOMETER, done=lambda: reported.append(1))
    assert len(found) == len(reported) == CASES
    counts = {name: len(answers[min(RISKS)]) for name, answers in found.items()}
    assert list(counts.values()) == [POINTS * SCANS // 2, POINTS * SCANS, POINTS * SCANS, POINTS * SCANS]
    for answers in found.values():
        assert len({a.walk for a in answers[min(RISKS)]}) == POINTS
        assert all(a.waypoint for a in answers[min(RISKS)])


def test_a_point_that_is_left_out_is_harder_than_one_that_the_map_knows() -> None:
    found = two_surveys(_survey(0.0), _survey(0.0), SUREFIX)
    mean_m = {
        name: np.mean([a.error_m for a in answers[min(RISKS)] if a.error_m is not None])
        for name, answers in found.items()
    }
    assert mean_m["known points, second survey"] < mean_m["points left out, second survey"]
    assert mean_m["points left out, second survey"] < 6.0


def test_the_open_surveys_are_read_whole() -> None:
    for survey in ("2019-06-11", "2019-07-03"):
        standing = read_standing(open_data("um_dsi", survey))
        assert len(standing) == 980
        assert {one.point for one in standing} == set(range(49))
        assert all(len(one.scan.bssid) == len(set(one.scan.bssid.tolist())) > 0 for one in standing)
        assert all(-110.0 < level < 0.0 for one in standing for level in one.scan.rssi_dbm)
        times = [one.scan.time_s for one in standing]
        assert times == sorted(times)


def test_files_that_do_not_fit_together_are_refused_by_name(tmp_path: Path) -> None:
    folder = tmp_path / "2020-01-01"
    folder.mkdir()
    with pytest.raises(InvalidInput, match="2020-01-01"):
        read_standing(folder)
    texts = {"coordinates": "1.0,2.0,1.0\n1.0,2.0,1.0", "rssis": "7:-60,8:-70", "timestamps": "20190611101430447"}
    for name, text in texts.items():
        (folder / f"{name}.csv.xz").write_bytes(lzma.compress(text.encode()))
    with pytest.raises(InvalidInput, match="standing scans"):
        read_standing(folder)
