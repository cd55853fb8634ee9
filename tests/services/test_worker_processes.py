"""What is large is read in another process, so that phones do not wait for it."""

from __future__ import annotations

import asyncio
import os

import pytest

from app.errors import InvalidInput, NotFound
from app.services.worker_processes import LARGE_BYTES, WorkerProcesses


def refuse(kind: type[InvalidInput | NotFound]) -> None:
    raise kind("no", "plan.features[3]")


@pytest.mark.parametrize(("size_bytes", "elsewhere"), [(0, False), (LARGE_BYTES - 1, False), (LARGE_BYTES, True)])
def test_what_is_large_is_worked_on_in_another_process(
    workers: WorkerProcesses, size_bytes: int, elsewhere: bool
) -> None:
    assert (asyncio.run(workers.run_of(size_bytes, os.getpid)) != os.getpid()) is elsewhere


@pytest.mark.parametrize("kind", [InvalidInput, NotFound])
@pytest.mark.parametrize("size_bytes", [0, LARGE_BYTES])
def test_a_refusal_keeps_its_field_on_the_way(
    workers: WorkerProcesses, kind: type[InvalidInput | NotFound], size_bytes: int
) -> None:
    with pytest.raises(kind, match="no") as refused:
        asyncio.run(workers.run_of(size_bytes, refuse, kind))
    assert vars(refused.value)["field"] == "plan.features[3]"
