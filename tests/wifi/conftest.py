"""Matchers are compiled before the tests, as they are before requests."""

from __future__ import annotations

import pytest

from app.wifi.kernels import warm_up


@pytest.fixture(scope="session", autouse=True)
def _compiled() -> None:
    warm_up()
