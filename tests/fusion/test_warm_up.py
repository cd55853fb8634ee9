"""Warming up leaves nothing for the first request to compile."""

from __future__ import annotations

from app.fusion import walking_ukf
from app.fusion.methods import METHODS
from app.fusion.warm_up import warm_up
from app.wifi.match import nearest
from tests.fusion.walks import run, walked


def test_a_walk_after_warming_up_compiles_nothing_more() -> None:
    warm_up()
    compiled = (walking_ukf.predict, walking_ukf.expect, nearest)
    before = [len(function.signatures) for function in compiled]
    for method in METHODS.values():
        run(method, walked(5).batches[:30])
    assert [len(function.signatures) for function in compiled] == before
    assert min(before) > 0
