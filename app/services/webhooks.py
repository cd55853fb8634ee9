"""Webhooks: where those who run a venue want to be told of alerts."""

from __future__ import annotations

import base64
import ipaddress
import re
import secrets
import socket
from collections.abc import Callable
from dataclasses import dataclass
from urllib.parse import urlsplit

import httpx

from app.errors import Conflict, InvalidInput, NotFound
from app.services.venues import Venues
from app.storage.webhook_rows import WebhookRow, WebhookRows

MOST = 20
"""Webhooks of a venue."""
LONGEST_URL = 2000
SECRET_PREFIX = "whsec_"
BARRED = tuple(map(ipaddress.ip_network, ("169.254.0.0/16", "fe80::/10", "fd00:ec2::254/128", "100.100.100.200/32")))
"""Link-local addresses and those where clouds tell a machine its secrets; alerts have no receiver there."""
_SECRET_BYTES = 32
_WEBHOOK = re.compile(r"[0-9a-f]{32}")
"""As secrets.token_hex(16) makes them."""


@dataclass(frozen=True, slots=True)
class NewWebhook:
    """A webhook just made. secret : is shown this once."""

    webhook: str
    url: str
    secret: str
    created_ms: int


class Webhooks:
    """What administrators may do with webhooks.

    Each method raises NotFound where there is no such venue, DependencyDown where the database cannot be reached.

    Parameters
    ----------
    now_ms : the server's clock.
    """

    def __init__(self, rows: WebhookRows, venues: Venues, now_ms: Callable[[], int]) -> None:
        self._rows = rows
        self._venues = venues
        self._now_ms = now_ms

    async def add(self, venue: str, url: str) -> NewWebhook:
        """Register an address; its secret is new.

        Raises
        ------
        InvalidInput : the address is not one that can be posted to.
        Conflict : the venue has as many as it may have.
        """
        refuse_address(url)
        secret, now_ms = secrets.token_bytes(_SECRET_BYTES), self._now_ms()
        made = NewWebhook(secrets.token_hex(16), url, shown_secret(secret), now_ms)
        if not await self._rows.add(await self._venues.key(venue), made.webhook, url, secret, now_ms, MOST):
            raise Conflict(f"a venue has {MOST} webhooks at most; remove one first")
        return made

    async def listed(self, venue: str) -> list[WebhookRow]:
        """Every webhook of a venue, oldest first, without the secrets."""
        return await self._rows.listed(await self._venues.key(venue))

    async def remove(self, venue: str, webhook: str) -> None:
        """Remove one; what was on its way to it is not sent any more. Raises NotFound where there is none, too."""
        key = await self._venues.key(venue)
        if not _WEBHOOK.fullmatch(webhook) or not await self._rows.remove(key, webhook):
            raise NotFound(f"venue {venue[:64]!r} has no webhook {webhook[:32]!r}")


def shown_secret(secret: bytes) -> str:
    """A secret as receivers' libraries take it."""
    return SECRET_PREFIX + base64.b64encode(secret).decode()


def refuse_address(url: str) -> None:
    """Nothing, if a URL can be posted to.

    Raises
    ------
    InvalidInput : it cannot, it holds a password, which every listing would show, or its address is barred.
    """
    try:
        parts = urlsplit(url)
        httpx.URL(url).host  # noqa: B018  what delivers reads it so, and refuses international names that are none
        usable = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except (ValueError, httpx.InvalidURL) as error:
        raise InvalidInput(f"this is not a URL: {error}", "url") from error
    if not usable or len(url) > LONGEST_URL or not url.isascii() or not url.isprintable() or " " in url:
        raise InvalidInput(f"a webhook is an http or https URL of at most {LONGEST_URL} ASCII characters", "url")
    if parts.username is not None or parts.password is not None or parts.fragment:
        raise InvalidInput("the URL of a webhook has no user, password or fragment", "url")
    if is_barred((parts.hostname or "").rstrip(".")):
        raise InvalidInput("no alerts are sent to link-local and metadata addresses: name the receiver's own", "url")


def is_barred(host: str) -> bool:
    """Whether a host is an address, however it is written, that nothing is sent to; a name is none."""
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        try:
            address = ipaddress.IPv4Address(socket.inet_aton(host))  # 0xa9.254.43518, as resolvers read it
        except (OSError, ValueError):
            return False
    address = getattr(address, "ipv4_mapped", None) or address
    return any(address in network for network in BARRED)
