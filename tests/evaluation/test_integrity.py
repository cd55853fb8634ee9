from __future__ import annotations

import io
import json
import math
from pathlib import Path

import matplotlib as mpl
import pytest
from rich.console import Console

from app.evaluation.campaign import Protocol
from app.evaluation.integrity import integrity, usable_at
from app.evaluation.stanford import stanford, stanford_shares
from app.evaluation.tables import document, integrity_table
from app.observations import Flag
from tests.evaluation.answers import answer

ANSWERS = [
    answer(1.0, protection_level_m=6.0),
    answer(7.0, protection_level_m=6.0),  # misleading
    answer(12.0, protection_level_m=9.0, walk="two"),  # hazardous at 10 m, misleading at each
    answer(2.0, protection_level_m=14.0, walk="two", usable=False, covered=False),
    answer(30.0, protection_level_m=8.0, walk="three", flag=Flag.FAULT, usable=False),
    answer(None, walk="three"),
]


def test_usable_at_another_limit_follows_from_the_level_and_the_flag() -> None:
    assert usable_at(answer(protection_level_m=10.0), 10.0)
    assert not usable_at(answer(protection_level_m=10.1), 10.0)
    assert usable_at(answer(protection_level_m=10.1, usable=False), 15.0)
    assert not usable_at(answer(protection_level_m=1.0, flag=Flag.FAULT), 20.0)
    assert not usable_at(answer(None), 20.0)


def test_each_figure_counts_what_its_name_says() -> None:
    found = integrity(ANSWERS)
    assert found.walks == 3
    assert found.inside_level.share == pytest.approx(2 / 5)
    assert found.inside_level_covered.share == pytest.approx(1 / 4)
    assert found.level_median_m == 8.0
    assert found.false_alert_walks == 1
    assert found.false_alert_share == pytest.approx(1 / 3)
    at_10, at_15, at_20 = found.limits
    assert [at.available.share for at in (at_10, at_15)] == pytest.approx([3 / 6, 4 / 6])
    assert at_10.available_covered.share == pytest.approx(3 / 5)
    assert [at.misleading.share for at in found.limits] == pytest.approx([2 / 6] * 3)
    assert [at.hazardous.share for at in (at_10, at_15, at_20)] == pytest.approx([1 / 6, 0.0, 0.0])
    assert (at_10.hazardous.walks, at_15.hazardous.walks) == (1, 0)


def test_a_share_lies_between_its_bounds() -> None:
    shares = [integrity(ANSWERS).inside_level, integrity(ANSWERS).limits[0].available]
    assert all(one.lower_95 <= one.share <= one.upper_95 for one in shares)


def test_a_wrong_floor_is_hazardous_however_small_the_error() -> None:
    assert integrity([answer(1.0, floor_right=False)]).limits[0].hazardous.share == 1.0


def test_levels_that_grow_with_the_error_correlate_and_equal_ones_do_not() -> None:
    grows = [answer(float(k), protection_level_m=2.0 * k + 3.0) for k in range(5)]
    assert integrity(grows).level_error_correlation == pytest.approx(1.0)
    assert math.isnan(integrity([answer(float(k)) for k in range(5)]).level_error_correlation)


def test_no_answer_has_no_figure() -> None:
    found = integrity([])
    assert found.walks == 0
    assert math.isnan(found.inside_level.share) and math.isnan(found.limits[0].available.share)


def test_the_table_and_the_document_show_the_figures_with_their_bounds() -> None:
    console = Console(width=200, file=io.StringIO())
    console.print(integrity_table({"one": integrity(ANSWERS)}, Protocol()))
    text = console.file.getvalue()  # type: ignore[attr-defined]
    assert "promised inside the level 0.99" in text
    assert "40.0 % (>=" in text and "16.67 % (<=" in text and "0.00 % (<=-)" in text
    plain = json.loads(json.dumps(document({"one": ANSWERS}, Protocol()), allow_nan=False))
    limits = plain["methods"]["one"]["integrity"]["limits"]
    assert limits[0]["hazardous"]["walks"] == 1
    assert limits[1]["hazardous"]["upper_95"] is None


def test_every_answer_that_makes_a_claim_falls_into_one_region() -> None:
    shares = stanford_shares(ANSWERS, 10.0)
    assert sum(shares.values()) == pytest.approx(1.0)
    assert shares["nominal"] == pytest.approx(1 / 4)
    assert shares["misleading"] == pytest.approx(1 / 4)
    assert shares["hazardous"] == pytest.approx(1 / 4)
    assert shares["unavailable"] == pytest.approx(1 / 4)
    assert stanford_shares([answer(1.0, floor_right=False)], 10.0)["hazardous"] == 1.0


def test_the_diagram_is_drawn_with_and_without_answers(tmp_path: Path) -> None:
    for name, answers in (("some", ANSWERS), ("none", [])):
        stanford(answers, 10.0, name, tmp_path / f"{name}.png")
        picture = mpl.image.imread(tmp_path / f"{name}.png")
        assert (picture[..., :3].min(axis=2) < 0.99).mean() > 0.3  # the regions are filled
