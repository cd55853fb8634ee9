"""The comparison's figures are right, and its page says what did not come out, and why."""

from __future__ import annotations

import math
import re
from typing import Any

import pytest

from app.evaluation.alone import ROWS
from app.evaluation.comparison import OPEN, RowFigures, Verdict, figures, outcome, outcomes, rows_from
from app.evaluation.comparison_page import page
from app.evaluation.paper_figures import CLAIMS, PUBLISHED, STATISTICS, Claim
from app.evaluation.paper_sites import paper_sites
from app.evaluation.written_figures import plain
from tests.evaluation.answers import answer

WHY = "because of the walls"
CLAIM = Claim("A-floor1", "integrity_ukf", "wifi_alone", why=WHY)
"""Of the paper: 1.02 against 2.37 m, 57 % less."""


def row(mean: float = 2.0, gross: float = math.nan) -> RowFigures:
    return RowFigures(10, mean, 1.2 * mean, 0.9 * mean, 2.0 * mean, 0.6, gross, 150.0)


def document(ours: float, theirs: float) -> dict[str, Any]:
    rows = plain({"integrity_ukf": row(ours), "integrity_ukf_plain": row(ours + 0.3), "wifi_alone": row(theirs)})
    described = {"title": "Floor", "method": "integrity_ukf", "stated": "a corridor", "assumed": "rooms", "walks": 2}
    return {
        "seed": 1,
        "jobs": 2,
        "seconds": 300.0,
        "sites": {"A-floor1": {**described, "rows": rows}},
        OPEN: {
            "seconds": 100.0,
            "walks": {"fold 0": 4, "fold 1": 5},
            "parts": {"pooled": rows, "fold 0": rows, "fold 1": rows},
        },
    }


def test_figures_are_those_of_covered_waypoints() -> None:
    answers = [answer(error_m) for error_m in (0.5, 1.0, 3.0, 4.0)]
    answers += [answer(50.0, waypoint=False), answer(60.0, covered=False), answer(None)]
    found = figures(answers, steps=35)
    assert (found.n, found.median, found.p95) == (4, 3.0, 4.0)
    assert found.mean == pytest.approx(2.125)
    assert found.rms == pytest.approx(math.sqrt((0.25 + 1.0 + 9.0 + 16.0) / 4.0))
    assert found.beyond_1m == 0.5
    assert found.step_us == pytest.approx(1000.0 * 7 / 35)
    assert math.isnan(found.gross)


def test_one_slow_batch_does_not_make_a_method_slow() -> None:
    answers = [answer(1.0, spent_s=0.001)] * 9 + [answer(1.0, spent_s=5.0)]
    assert figures(answers, steps=20).step_us == pytest.approx(500.0)


def test_errors_at_gross_errors_are_those_just_after_such_a_scan_in_that_walk() -> None:
    answers = [answer(float(t), time_s=float(t), walk=walk) for walk in ("one", "two") for t in range(1, 10)]
    assert figures(answers, 10, {"one": (2.5, 6.0)}).gross == pytest.approx((3.0 + 6.0) / 2.0)


def test_no_answers_have_no_figures() -> None:
    found = figures([], 0)
    assert found.n == 0
    assert math.isnan(found.mean) and math.isnan(found.step_us) and math.isnan(found.beyond_1m)


@pytest.mark.parametrize(
    ("ours", "verdict"),
    [(1.0, Verdict.REPRODUCED), (1.4, Verdict.REPRODUCED), (1.9, Verdict.WEAKER), (2.0, Verdict.NOT_REPRODUCED),
     (3.0, Verdict.NOT_REPRODUCED), (math.nan, Verdict.NOT_MEASURED)],
)  # fmt: skip
def test_half_of_the_papers_improvement_is_enough_and_none_is_not(ours: float, verdict: Verdict) -> None:
    found = outcome(CLAIM, {"integrity_ukf": row(ours), "wifi_alone": row(2.0)}, {})
    assert found.verdict is verdict
    assert found.paper_improvement == pytest.approx(1.0 - 1.02 / 2.37)


def test_the_open_walks_stand_beside_but_do_not_decide() -> None:
    site, recorded = (
        {"integrity_ukf": row(1.0), "wifi_alone": row(2.0)},
        {"integrity_ukf": row(6.0), "wifi_alone": row(5.0)},
    )
    found = outcome(CLAIM, site, recorded)
    assert found.verdict is Verdict.REPRODUCED
    assert found.open_improvement == pytest.approx(-0.2)


def test_a_row_that_was_not_walked_leaves_the_claim_unmeasured() -> None:
    assert outcome(CLAIM, {"wifi_alone": row()}, {}).verdict is Verdict.NOT_MEASURED
    assert {one.claim.site for one in outcomes({"A-floor1": {"wifi_alone": row()}, OPEN: {}})} == {"A-floor1"}


def test_no_reason_written_by_hand_names_an_error_that_is_measured_anew() -> None:
    assert [claim.why for claim in CLAIMS if re.search(r"errs? by \d|\d\.\d+ m\b", claim.why)] == []


@pytest.mark.parametrize(
    "claim", CLAIMS, ids=lambda claim: f"{claim.site}-{claim.better}-{claim.worse}-{claim.statistic}"
)
def test_every_claim_is_of_the_papers_and_of_rows_that_exist(claim: Claim) -> None:
    assert {claim.better, claim.worse} <= set(ROWS)
    assert claim.site in {paper.site for paper in paper_sites()}
    published, statistic = PUBLISHED[claim.site], claim.statistic
    assert statistic in STATISTICS
    assert published[claim.better][statistic] < published[claim.worse][statistic]
    assert claim.why


def test_figures_survive_being_written_down() -> None:
    rows = {"one": row(math.nan), "two": row(gross=3.0)}
    again = rows_from(plain(rows))
    assert again["two"] == rows["two"]
    assert math.isnan(again["one"].mean) and math.isnan(again["one"].gross)


def test_the_page_gives_the_reason_where_a_result_does_not_come_out_and_only_there() -> None:
    weak, strong = (page(document(ours, 2.0), None) for ours in (1.9, 0.8))
    assert "A-floor1, `integrity_ukf` against `wifi_alone`, mean error (weaker)" in weak
    assert f": {CLAIMS[0].why}." in weak
    assert CLAIMS[0].why not in strong


def test_the_page_sets_the_papers_figure_beside_ours_and_the_best_row_first() -> None:
    text = page(document(0.8, 2.0), "pictures")
    assert (
        "| A-floor1 | `integrity_ukf` | `wifi_alone` | mean error | 1.02 < 2.37 | 0.80 < 2.00 | 57 % | 60 % |" in text
    )
    assert "0.80 / 1.02" in text
    site = text[text.index("## Floor (A-floor1)") :]
    assert site.index("`integrity_ukf`") < site.index("`wifi_alone`")
    assert "![Distribution of the error, A-floor1](pictures/cdf_A-floor1.png)" in text
    assert "9 recorded walks" in text and "Fold 0 alone is 4 walks" in text and "5 minutes" in text
