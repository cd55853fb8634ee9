from __future__ import annotations

from collections.abc import Iterator

import pytest

from app.services.worker_processes import WorkerProcesses


@pytest.fixture(scope="session")
def workers() -> Iterator[WorkerProcesses]:
    """A process for what the service does in others, shared by all tests: it takes seconds to start."""
    shared = WorkerProcesses(1)
    yield shared
    shared.stop()
