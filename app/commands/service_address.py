"""The address of a running service, as a command is told it."""

from __future__ import annotations

import httpx

from app.errors import InvalidInput


def service_address(url: str) -> httpx.URL:
    """The address. Raises InvalidInput, naming the option, for what is none."""
    try:
        address = httpx.URL(url)
    except httpx.InvalidURL as error:
        raise InvalidInput(
            f"url: {url} is no address of a service ({error}); http://host:port is one", "url"
        ) from error
    if address.scheme not in ("http", "https") or not address.host:
        raise InvalidInput(f"url: {url} is no address of a service; http://host:port is one", "url")
    return address


def shown(address: httpx.URL) -> str:
    """The address without a password, as messages show it."""
    return str(address.copy_with(userinfo=b"")).rstrip("/")
