"""POST /v1/venues/{venue}/surveys and the tasks behind `Prefer: respond-async`."""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import orjson
from fastapi import APIRouter, Depends, Header, Query, Request, Response
from pydantic import BaseModel, Field

from app.api.problems import TYPE, problem_of
from app.api.upload_body import drain, receive_upload
from app.errors import InvalidInput, SurefixError
from app.services.surveys import Receipt, Surveys
from app.services.tasks import Tasks, TaskStatus
from app.survey.upload import Upload

_ASYNC = re.compile(r"(?:^|[,;\s])respond-async(?:$|[,;\s])", re.IGNORECASE)
_LOST = {
    "type": f"{TYPE}task-lost",
    "title": "The task ended with the process that ran it",
    "status": 503,
    "detail": "nothing was stored; send the survey again",
}


class RejectionBody(BaseModel):
    """What did not land, and why. `item`: row of a CSV (the header is 1), path in a JSON body, file or file:line."""

    item: str | int
    reason: str


class ReceiptBody(BaseModel):
    """What became of a survey. `rejected` lists the first 1000 rejections, `rejected_count` counts them all.

    `version`: number of the radio map that is active now because of `publish=true`, else null.
    """

    survey: int
    accepted: Annotated[int, Field(description="fingerprints that landed")]
    rejected: list[RejectionBody]
    rejected_count: int
    version: int | None


class StartedBody(BaseModel):
    """Where to ask how the survey stands."""

    task: str


class TaskBody(BaseModel):
    """A task. `receipt` once it is done; `problem`, as the request would have been answered, once it failed."""

    task: str
    status: TaskStatus
    receipt: ReceiptBody | None
    problem: dict[str, Any] | None


_FILES = {"type": "array", "items": {"type": "string", "format": "binary"}}
_REQUEST = {
    "requestBody": {
        "required": True,
        "content": {
            "application/json": {
                "schema": {
                    "type": "object",
                    "required": ["floor", "fingerprints"],
                    "properties": {
                        "floor": {"type": "string"},
                        "device": {
                            "type": "object",
                            "properties": {"brand": {"type": "string"}, "model": {"type": "string"}},
                        },
                        "fingerprints": {
                            "type": "array",
                            "items": {
                                "type": "object",
                                "required": ["x", "y", "t", "readings"],
                                "properties": {
                                    "x": {"type": "number", "description": "m"},
                                    "y": {"type": "number", "description": "m"},
                                    "t": {"type": "number", "description": "Unix ms"},
                                    "readings": {
                                        "type": "array",
                                        "items": {
                                            "type": "object",
                                            "required": ["bssid", "rssi"],
                                            "properties": {
                                                "bssid": {"type": "string"},
                                                "rssi": {"type": "number", "description": "dBm"},
                                                "frequency": {"type": "number", "description": "MHz"},
                                                "ssid": {"type": "string"},
                                            },
                                        },
                                    },
                                    "bluetooth": {
                                        "type": "array",
                                        "items": {
                                            "type": "object",
                                            "required": ["id", "rssi"],
                                            "properties": {
                                                "id": {"type": "string", "description": "uuid:major:minor"},
                                                "rssi": {"type": "number", "description": "dBm"},
                                            },
                                        },
                                    },
                                },
                            },
                        },
                    },
                }
            },
            "text/csv": {"schema": {"type": "string", "description": "floor,x,y,t,bssid,rssi[,frequency][,ssid]"}},
            "multipart/form-data": {
                "schema": {"type": "object", "required": ["files"], "properties": {"files": _FILES}}
            },
        },
    }
}


def surveys_router(
    surveys: Callable[..., Any], tasks: Callable[..., Any], survey: Callable[..., Any], limit_bytes: int
) -> APIRouter:
    """The endpoints.

    Parameters
    ----------
    surveys, tasks : dependencies that give the Surveys and the Tasks.  survey : dependency that lets only scope
    `survey` pass.  limit_bytes : largest body.
    """
    router = APIRouter(prefix="/v1", tags=["surveys"], dependencies=[Depends(survey)])

    @router.post(
        "/venues/{venue}/surveys",
        status_code=201,
        response_model=ReceiptBody,
        responses={202: {"model": StartedBody, "description": "with `Prefer: respond-async`"}},
        summary="Upload a survey",
        openapi_extra=_REQUEST,
    )
    async def upload_survey(
        venue: str,
        request: Request,
        response: Response,
        publish: Annotated[bool, Query(description="build the next radio map of all surveys and activate it")] = False,
        floor: Annotated[str | None, Query(description="of the traces of a multipart body; needed there")] = None,
        prefer: Annotated[str, Header(description="`respond-async`: 202 and a task")] = "",
        service: Surveys = Depends(surveys),
        background: Tasks = Depends(tasks),
    ) -> Any:
        """Fingerprints as JSON or CSV, or walks as trace files (plain, gzip, xz or zip; repeated parts named `files`,
        `?floor=` required). `Content-Encoding: gzip` is accepted.

        What cannot be used is rejected one by one with its reason and the rest lands, in one transaction. A survey of
        which nothing can be used is 422 with the first reasons, and nothing lands.
        """
        folder = Path(tempfile.mkdtemp(prefix="surefix-upload-"))
        handed_over = False
        try:
            upload = await _received(request, service, venue, folder, floor, limit_bytes)
            if not _ASYNC.search(prefer):
                return receipt_body(await service.add(venue, upload, publish))
            task = await background.start(lambda: _in_background(service, venue, upload, publish, folder))
            handed_over = True
        finally:
            if not handed_over:
                shutil.rmtree(folder)
        response.status_code = 202
        response.headers["Location"] = f"/v1/tasks/{task}"
        response.headers["Preference-Applied"] = "respond-async"
        return Response(
            orjson.dumps({"task": f"/v1/tasks/{task}"}), 202, dict(response.headers), media_type="application/json"
        )

    @router.get("/tasks/{task}", response_model=TaskBody, summary="How an upload stands")
    async def read_task(task: str, background: Tasks = Depends(tasks)) -> Any:
        """Kept for a week."""
        state = await background.state(task)
        outcome = orjson.loads(state.outcome) if state.outcome else None
        failed = state.status is TaskStatus.FAILED
        return {
            "task": f"/v1/tasks/{task}",
            "status": state.status,
            "receipt": outcome if state.status is TaskStatus.DONE else None,
            "problem": (outcome or _LOST) if failed else None,
        }

    return router


def receipt_body(receipt: Receipt) -> ReceiptBody:
    """A receipt as it is answered."""
    return ReceiptBody(
        survey=receipt.survey,
        accepted=receipt.accepted,
        rejected=[RejectionBody(item=one.item, reason=one.reason) for one in receipt.rejected],
        rejected_count=receipt.rejected_count,
        version=receipt.version,
    )


async def _received(
    request: Request, service: Surveys, venue: str, folder: Path, floor: str | None, limit_bytes: int
) -> Upload:
    """The upload, with what can be refused before hundreds of megabytes have come refused at once."""
    try:
        _, _, extents = await service.floors(venue)
        if floor is not None and floor not in extents:
            names = ", ".join(sorted(extents)) or "it has none yet"
            raise InvalidInput(f"floor must name a floor of the venue: {names}", "floor")
        return await receive_upload(request, folder, floor, limit_bytes)
    except SurefixError:
        await drain(request)
        raise


async def _in_background(
    service: Surveys, venue: str, upload: Upload, publish: bool, folder: Path
) -> tuple[TaskStatus, bytes]:
    try:
        receipt = receipt_body(await service.add(venue, upload, publish))
        return TaskStatus.DONE, orjson.dumps(receipt.model_dump())
    except SurefixError as error:
        problem = problem_of(error)
        document: dict[str, Any] = {"type": TYPE + problem.name, "title": problem.title, "status": problem.status}
        if isinstance(error, InvalidInput) and error.field:
            document["field"] = error.field
        return TaskStatus.FAILED, orjson.dumps({**document, "detail": str(error)})
    finally:
        shutil.rmtree(folder)
