"""Work that goes on after its request was answered: the answer 202, and GET /v1/tasks/{task}."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import orjson
from fastapi import APIRouter, Depends, Response
from pydantic import BaseModel

from app.api.problems import TYPE
from app.api.survey_body import ReceiptBody
from app.services.tasks import Tasks, TaskStatus

_LOST = {
    "type": f"{TYPE}task-lost",
    "title": "The task ended with the process that ran it",
    "status": 503,
    "detail": "nothing was stored; send the request again",
}


class StartedBody(BaseModel):
    """What was asked for is being made. `task`: where to ask how it stands."""

    task: str


class TaskBody(BaseModel):
    """A task. `receipt`: of a survey, once it is stored.  `problem`: as the request would have been answered, once it
    failed."""

    task: str
    status: TaskStatus
    receipt: ReceiptBody | None
    problem: dict[str, Any] | None


def tasks_router(tasks: Callable[..., Any], survey: Callable[..., Any]) -> APIRouter:
    """The endpoint.

    Parameters
    ----------
    tasks : dependency that gives the Tasks.  survey : dependency that lets pass who may survey.
    """
    router = APIRouter(prefix="/v1/tasks", tags=["tasks"], dependencies=[Depends(survey)])

    @router.get("/{task}", response_model=TaskBody, summary="How a task stands")
    async def read_task(task: str, service: Tasks = Depends(tasks)) -> Any:
        """A survey sent with `Prefer: respond-async` that is being stored, or a quality report that is being made. Kept
        for a week."""
        state = await service.state(task)
        outcome = orjson.loads(state.outcome) if state.outcome else None
        return {
            "task": task_path(task),
            "status": state.status,
            "receipt": outcome if state.status is TaskStatus.DONE else None,
            "problem": (outcome or _LOST) if state.status is TaskStatus.FAILED else None,
        }

    return router


def started(task: str, headers: Mapping[str, str]) -> Response:
    """The answer to a request whose work goes on."""
    path = task_path(task)
    return Response(orjson.dumps({"task": path}), 202, {"Location": path, **headers}, media_type="application/json")


def task_path(task: str) -> str:
    """Where to ask how a task stands."""
    return f"/v1/tasks/{task}"
