from __future__ import annotations

import os
from collections.abc import Iterator

import pytest
from hypothesis import settings

from app.services.worker_processes import WorkerProcesses

# a slow moment of the machine is no failure; and what CI says of one commit it says again
settings.register_profile("here", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") == "true" else "here")


@pytest.fixture(scope="session")
def workers() -> Iterator[WorkerProcesses]:
    """A process for what the service does in others, shared by all tests: it takes seconds to start."""
    shared = WorkerProcesses(1)
    yield shared
    shared.stop()
