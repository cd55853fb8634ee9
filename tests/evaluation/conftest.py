from __future__ import annotations

from pathlib import Path

import pytest

from tests.evaluation.small_site import write_small_site


@pytest.fixture(scope="session")
def small_site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_small_site(tmp_path_factory.mktemp("site"))
