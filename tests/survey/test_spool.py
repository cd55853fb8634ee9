from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.survey.spool import read_rows, write_row

ROWS = [("F1", "walk", 1.5, 2.0, 3.0, b"readings"), ("F2", "", 2.5, -1.0, 0.0, b"")]


def spooled() -> bytes:
    stream = io.BytesIO()
    for row in ROWS:
        write_row(stream, row)
    return stream.getvalue()


def test_rows_come_back_as_they_were_written() -> None:
    assert list(read_rows(io.BytesIO(spooled()))) == ROWS


@given(st.integers(0, len(spooled())))
def test_a_spool_that_ends_within_a_row_is_refused_wherever_it_was_cut(at: int) -> None:
    first = io.BytesIO()
    write_row(first, ROWS[0])
    if at in (0, len(first.getvalue()), len(spooled())):
        assert len(list(read_rows(io.BytesIO(spooled()[:at])))) < 3
        return
    with pytest.raises(ValueError, match=r"."):
        list(read_rows(io.BytesIO(spooled()[:at])))
