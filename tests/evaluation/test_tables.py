from __future__ import annotations

import io
import json

import pytest
from rich.console import Console

from app.evaluation.campaign import Protocol
from app.evaluation.scoring import score
from app.evaluation.tables import document, error_table, parts_table, trust_table
from app.observations import Flag
from tests.evaluation.answers import answer

ANSWERS = {
    "one": [answer(1.0), answer(3.0, floor="F2"), answer(12.0, covered=False, fold=1), answer(None)],
    "two": [answer(None, flag=Flag.INITIALISING)],
}


def test_the_document_is_plain_json_without_nan_and_splits_by_floor_and_fold() -> None:
    text = json.dumps(document(ANSWERS, Protocol(tested=(0, 1))), allow_nan=False)
    methods = json.loads(text)["methods"]
    assert methods["one"]["all"]["waypoints_covered"]["mean_m"] == pytest.approx(2.0)
    assert methods["one"]["floors"]["F2"]["every_answer"]["mean_m"] == pytest.approx(3.0)
    assert methods["one"]["folds"]["1"]["hazardous"] == 1.0
    assert methods["two"]["all"]["every_answer"]["mean_m"] is None
    assert json.loads(text)["protocol"]["tested"] == [0, 1]


def test_the_tables_show_every_method_and_a_dash_for_what_is_not_known() -> None:
    scores = {name: score(found) for name, found in ANSWERS.items()}
    console = Console(width=160, file=io.StringIO())
    for table in (error_table(scores), trust_table(scores, Protocol()), parts_table(ANSWERS)):
        console.print(table)
    text = console.file.getvalue()  # type: ignore[attr-defined]
    rows = [" ".join(line.split()) for line in text.splitlines()]
    assert "one 2 2.00 2.24 3.00 3.00 3.00" in rows
    assert "two 0 - - - - -" in rows
    assert "one 1.00 / 1.0 3.00 / 3.0 2.00 / 3.0 - / -" in rows  # floor F1, floor F2, fold 0, fold 1
    assert "25.00 %" in text  # hazardous: one of four
