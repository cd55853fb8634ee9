"""POST /v1/venues/{venue}/surveys."""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import orjson
from fastapi import APIRouter, Depends, Header, Query, Request

from app.api.survey_body import REQUEST, ReceiptBody, receipt_body
from app.api.tasks import StartedBody, started
from app.api.upload_body import drain, receive_upload
from app.errors import SurefixError
from app.services.left_behind import ShortLived
from app.services.surveys import Surveys
from app.services.tasks import Tasks
from app.survey.admission import named_floor
from app.survey.upload import Upload

_ASYNC = re.compile(r"(?:^|[,;\s])respond-async(?:$|[,;\s])", re.IGNORECASE)


def surveys_router(
    surveys: Callable[..., Any], tasks: Callable[..., Any], survey: Callable[..., Any], limit_bytes: int
) -> APIRouter:
    """The endpoint.

    Parameters
    ----------
    surveys, tasks : dependencies that give the Surveys and the Tasks.  survey : dependency that lets only scope
    `survey` pass.  limit_bytes : largest body.
    """
    router = APIRouter(prefix="/v1/venues/{venue}/surveys", tags=["surveys"], dependencies=[Depends(survey)])

    @router.post(
        "",
        status_code=201,
        response_model=ReceiptBody,
        responses={202: {"model": StartedBody, "description": "with `Prefer: respond-async`"}},
        summary="Upload a survey",
        openapi_extra=REQUEST,
    )
    async def upload_survey(
        venue: str,
        request: Request,
        publish: Annotated[bool, Query(description="build the next radio map of all surveys and activate it")] = False,
        floor: Annotated[str | None, Query(description="of the traces of a multipart body; needed there")] = None,
        prefer: Annotated[str, Header(description="`respond-async`: 202 and a task")] = "",
        service: Surveys = Depends(surveys),
        background: Tasks = Depends(tasks),
    ) -> Any:
        """Fingerprints as JSON or CSV, or walks as trace files (plain, gzip, xz or zip; repeated parts named `files`,
        `?floor=` required). `Content-Encoding: gzip` is accepted.

        What cannot be used is rejected one by one with its reason and the rest lands, in one transaction. A survey of
        which nothing can be used is 422 with the first reasons, and nothing lands; one of an unknown floor is 404.
        """
        folder = Path(tempfile.mkdtemp(prefix=ShortLived.UPLOAD))
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
        return started(task, {"Preference-Applied": "respond-async"})

    return router


async def _received(
    request: Request, service: Surveys, venue: str, folder: Path, floor: str | None, limit_bytes: int
) -> Upload:
    """The upload, with what can be refused before hundreds of megabytes have come refused at once."""
    try:
        _, _, extents = await service.floors(venue)
        if floor is not None:
            named_floor(extents, floor)
        return await receive_upload(request, folder, floor, limit_bytes)
    except SurefixError:
        await drain(request)
        raise


async def _in_background(service: Surveys, venue: str, upload: Upload, publish: bool, folder: Path) -> bytes:
    try:
        return orjson.dumps(receipt_body(await service.add(venue, upload, publish)).model_dump())
    finally:
        shutil.rmtree(folder)
