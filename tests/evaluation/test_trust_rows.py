from __future__ import annotations

import io
import json
import math
from dataclasses import replace

from rich.console import Console

from app.evaluation.trust_rows import TrustRow, trust_row, trust_rows_table
from app.evaluation.written_figures import plain
from app.observations import Flag
from tests.evaluation.answers import answer


def test_errors_are_of_covered_waypoints_and_levels_of_every_answer() -> None:
    found = [answer(1.0), answer(3.0), answer(20.0, covered=False), answer(9.0, waypoint=False)]
    row = trust_row({0.01: found})
    assert (row.error_mean_m, row.error_all_m) == (2.0, 8.25)
    assert row.at_risk[0].inside_level.share == 0.5
    assert row.at_risk[0].inside_level_covered.share == 2 / 3
    assert row.inside_68.share == 0.25


def test_each_risk_has_its_own_level_and_the_smallest_comes_first() -> None:
    answers = {0.05: [answer(5.0, protection_level_m=4.0)], 0.01: [answer(5.0, protection_level_m=6.0)]}
    row = trust_row(answers)
    assert row.risks == (0.01, 0.05)
    assert [one.inside_level.share for one in row.at_risk] == [1.0, 0.0]
    assert [at.available.share for at in row.at_risk[0].limits] == [1.0, 1.0, 1.0]


def test_a_walk_with_an_alarm_is_a_false_one_and_counts_once() -> None:
    alarmed = answer(1.0, flag=Flag.FAULT, usable=False)
    found = [alarmed, replace(alarmed, time_s=1.0), answer(1.0, walk="two")]
    assert (trust_row({0.01: found}).walks, trust_row({0.01: found}).at_risk[0].false_alert_walks) == (2, 1)


def test_a_wrong_floor_is_outside_of_every_radius() -> None:
    row = trust_row({0.01: [answer(0.1, floor_right=False), answer(0.1)]})
    assert row.floor_right == row.inside_68.share == row.at_risk[0].inside_level.share == 0.5


def test_the_table_has_a_line_for_each_row_under_its_words() -> None:
    rows: dict[tuple[str, ...], TrustRow] = {
        ("one", "a"): trust_row({0.01: [answer()]}),
        ("two", "b"): trust_row({0.01: [answer(30.0)]}),
    }
    table = trust_rows_table(rows, "title", ["what", "how"])
    console = Console(width=240, file=io.StringIO(), record=True)
    console.print(table)
    lines = console.export_text().splitlines()
    (line,) = (line for line in lines if line.split()[:1] == ["two"])
    assert line.split()[:6] == ["two", "b", "1", "0", "(0)", "30.0"]
    assert any("risk 0.01" in one for one in lines)


def test_a_row_is_plain_json_with_null_where_there_is_no_figure() -> None:
    row = trust_row({0.01: [answer(None)]})
    assert math.isnan(row.error_mean_m)
    document = json.loads(json.dumps(plain({"row": row}), allow_nan=False))
    assert document["row"]["error_mean_m"] is None
    assert document["row"]["at_risk"][0]["limits"][0]["alert_limit_m"] == 10.0
