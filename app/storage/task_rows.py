"""Tasks in the database, so that every worker can tell how any of them stands."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import delete, insert, select, update
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.database import reachable
from app.storage.tables import tasks


@dataclass(frozen=True, slots=True)
class TaskRow:
    """A task. Times are Unix ms of the server's clock; alive_ms : when its worker last said that it runs."""

    task: str
    status: str
    created_ms: int
    alive_ms: int
    outcome: bytes | None


class TaskRows:
    """Reads and writes tasks. Each method raises DependencyDown where the database cannot be reached."""

    def __init__(self, engine: AsyncEngine) -> None:
        self._engine = engine

    async def add(self, row: TaskRow, forget_before_ms: int) -> None:
        """Insert a task, and forget those made before a time."""
        values = {
            "task": row.task,
            "status": row.status,
            "created_ms": row.created_ms,
            "alive_ms": row.alive_ms,
            "outcome": row.outcome,
        }
        async with reachable(), self._engine.begin() as connection:
            await connection.execute(delete(tasks).where(tasks.c.created_ms < forget_before_ms))
            await connection.execute(insert(tasks).values(values))

    async def read(self, task: str) -> TaskRow | None:
        """The task; None if there is none."""
        query = select(tasks.c.task, tasks.c.status, tasks.c.created_ms, tasks.c.alive_ms, tasks.c.outcome)
        async with reachable(), self._engine.connect() as connection:
            row = (await connection.execute(query.where(tasks.c.task == task))).one_or_none()
        return None if row is None else TaskRow(*row)

    async def keep_alive(self, task: str, now_ms: int) -> None:
        """Say that the task still runs."""
        async with reachable(), self._engine.begin() as connection:
            await connection.execute(update(tasks).where(tasks.c.task == task).values(alive_ms=now_ms))

    async def finish(self, task: str, status: str, outcome: bytes) -> None:
        """Write down how the task ended."""
        query = update(tasks).where(tasks.c.task == task).values(status=status, outcome=outcome)
        async with reachable(), self._engine.begin() as connection:
            await connection.execute(query)
