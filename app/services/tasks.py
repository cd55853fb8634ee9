"""Work that goes on after its request was answered, and how it stands."""

from __future__ import annotations

import asyncio
import logging
import re
import secrets
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import orjson

from app.errors import DependencyDown, NotFound, SurefixError, told_as
from app.storage.task_rows import TaskRow, TaskRows

HEARTBEAT_S = 20.0
AGAIN_S = 2.0
"""Between two tries to write down how a task ended, while the database is away."""
LOST_MS = 90_000
"""A task whose worker has been silent for longer has died with it."""
KEPT_MS = 7 * 86_400_000
_TASK = re.compile(r"[A-Za-z0-9_-]{22}")
"""As secrets.token_urlsafe(16) makes them."""
_log = logging.getLogger(__name__)


class TaskStatus(StrEnum):
    """How a task stands."""

    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class TaskState:
    """A task. outcome : JSON of what it gave or why it failed; None while it runs, and where it was lost."""

    task: str
    status: TaskStatus
    outcome: bytes | None


Job = Callable[[], Awaitable[bytes]]
"""Gives what is to be told of it, JSON or nothing; raises what its request would have been refused with."""


class Tasks:
    """Starts tasks in this process; any process can tell how they stand.

    Parameters
    ----------
    now_ms : the server's clock.  problem : the document that an error is answered with.

    Attributes
    ----------
    running : the tasks of this process.
    """

    def __init__(
        self, rows: TaskRows, now_ms: Callable[[], int], problem: Callable[[Exception], Mapping[str, Any]]
    ) -> None:
        self._rows = rows
        self._problem = problem
        self._now_ms = now_ms
        self._closing = False
        self.running: set[asyncio.Task[None]] = set()

    async def start(self, job: Job) -> str:
        """Let a job run; gives the task's unguessable name. Raises DependencyDown, not having started it."""
        task, now_ms = secrets.token_urlsafe(16), self._now_ms()
        row = TaskRow(task, TaskStatus.RUNNING.value, now_ms, now_ms, None)
        await self._rows.add(row, forget_before_ms=now_ms - KEPT_MS)
        running = asyncio.create_task(self._run(task, job))
        self.running.add(running)
        running.add_done_callback(self._ended)
        return task

    async def state(self, task: str) -> TaskState:
        """How a task stands. Raises NotFound for one that never was, or ended a week ago."""
        row = await self._rows.read(task) if _TASK.fullmatch(task) else None
        if row is None:
            raise NotFound("there is no such task")
        status = TaskStatus(row.status)
        if status is TaskStatus.RUNNING and self._now_ms() - row.alive_ms > LOST_MS:
            status = TaskStatus.FAILED
        return TaskState(task, status, row.outcome)

    async def close(self) -> None:
        """Stop what runs; it is told as failed."""
        self._closing = True
        for running in self.running:
            running.cancel()
        await asyncio.gather(*self.running, return_exceptions=True)

    async def _run(self, task: str, job: Job) -> None:
        status, outcome = TaskStatus.FAILED, b""
        heartbeat = asyncio.create_task(self._beat(task))
        try:
            outcome = await job()
            status = TaskStatus.DONE
        except Exception as error:
            outcome = orjson.dumps(self._problem(error))
            if not isinstance(told := told_as(error), SurefixError):
                raise  # a defect, which the log tells
            if isinstance(told, DependencyDown):
                _log.warning("a task failed: %s", told)
        finally:
            heartbeat.cancel()
            await self._finish(task, status, outcome)

    async def _beat(self, task: str) -> None:
        while True:
            await asyncio.sleep(HEARTBEAT_S)
            try:
                await self._rows.keep_alive(task, self._now_ms())
            except DependencyDown as error:
                _log.warning("that a task runs is told later: %s", error)

    async def _finish(self, task: str, status: TaskStatus, outcome: bytes) -> None:
        """Write down how it ended. What was done must not be told as lost, so while the service goes on it waits for
        the database."""
        while True:
            try:
                return await self._rows.finish(task, status.value, outcome)
            except DependencyDown as error:
                if self._closing:
                    raise
                _log.warning("how a task ended is told later: %s", error)
                await asyncio.sleep(AGAIN_S)

    def _ended(self, running: asyncio.Task[None]) -> None:
        self.running.discard(running)
        if not running.cancelled() and (error := running.exception()) is not None:
            _log.error("a task failed", exc_info=error)
