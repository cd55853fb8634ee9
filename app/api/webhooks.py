"""Webhooks of a venue: where alerts are sent."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request, Response
from pydantic import BaseModel, Field

from app.api import examples
from app.api.json_bodies import FROM_ADMINISTRATORS, parse_admin, read_json, request_body
from app.services.webhooks import LONGEST_URL, Webhooks

BODY_LIMIT_BYTES = 10_000


class WebhookBody(BaseModel):
    """The address to send alerts to."""

    model_config = FROM_ADMINISTRATORS

    url: Annotated[
        str, Field(max_length=LONGEST_URL, description="http or https, without user and fragment; not link-local")
    ]


class NewWebhookAnswer(BaseModel):
    """A new webhook. `secret` signs what is sent, and is shown this once. `created`: Unix ms, server's clock."""

    webhook: str
    url: str
    secret: str
    created: int


class WebhookAnswer(BaseModel):
    """A webhook. `delivered`: when an alert last arrived, null before the first. `failure`: why the newest attempt
    failed, null after one that succeeded. `waiting`: alerts still to be delivered. Times: Unix ms, server's clock."""

    webhook: str
    url: str
    created: int
    delivered: int | None
    failure: str | None
    waiting: int


class WebhookListAnswer(BaseModel):
    """All webhooks of a venue."""

    webhooks: list[WebhookAnswer]


def webhooks_router(webhooks: Callable[..., Any], admin: Callable[..., Any]) -> APIRouter:
    """The endpoints.

    Parameters
    ----------
    webhooks : dependency that gives the Webhooks.  admin : dependency that lets only scope `admin` pass.
    """
    router = APIRouter(prefix="/v1/venues/{venue}/webhooks", tags=["integrity"], dependencies=[Depends(admin)])

    @router.post(
        "",
        status_code=201,
        response_model=NewWebhookAnswer,
        summary="Send a venue's alerts to an address",
        openapi_extra=request_body(WebhookBody, example=examples.WEBHOOK),
    )
    async def add(venue: str, request: Request, service: Webhooks = Depends(webhooks)) -> NewWebhookAnswer:
        """When the flag of a session of the venue enters `fault` (`alert.raised`) and when it leaves (`alert.cleared`),
        the address gets a POST of `{"event", "type", "created", "venue", "phone", "sequence", "t", "flag", "floor",
        "excluded"}`; `phone` is the number that `/phones` shows, not the session.

        It is signed as Standard Webhooks are: `webhook-signature` is `v1,` and the base64 of HMAC-SHA256, under the
        base64-decoded rest of `secret` after `whsec_`, over `{webhook-id}.{webhook-timestamp}.{body}`. What is not
        answered 2xx within 10 s is sent again, after 2 s, then twice the time each time up to 15 minutes, for 24 hours.
        The same alert may come twice, with the same `webhook-id`, and alerts may overtake one another.
        """
        body = parse_admin(WebhookBody, await read_json(request, BODY_LIMIT_BYTES))
        made = await service.add(venue, body.url)
        return NewWebhookAnswer(webhook=made.webhook, url=made.url, secret=made.secret, created=made.created_ms)

    @router.get("", response_model=WebhookListAnswer, summary="A venue's webhooks and how they fare")
    async def listed(venue: str, service: Webhooks = Depends(webhooks)) -> WebhookListAnswer:
        """Oldest first."""
        return WebhookListAnswer(
            webhooks=[
                WebhookAnswer(
                    webhook=row.webhook,
                    url=row.url,
                    created=row.created_ms,
                    delivered=row.delivered_ms,
                    failure=row.failure,
                    waiting=row.waiting,
                )
                for row in await service.listed(venue)
            ]
        )

    @router.delete("/{webhook}", status_code=204, response_class=Response, summary="Send no more alerts to an address")
    async def remove(venue: str, webhook: str, service: Webhooks = Depends(webhooks)) -> Response:
        """What was on its way to it is dropped."""
        await service.remove(venue, webhook)
        return Response(status_code=204)

    return router
