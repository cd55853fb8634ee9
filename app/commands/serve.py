"""surefix serve: the service over HTTP."""

from __future__ import annotations

import asyncio
import errno
import os
import socket
import tempfile
import threading
import time
from typing import Annotated, Any
from urllib.parse import urlsplit

import httpx
import typer
import uvicorn

from app.errors import DependencyDown, InvalidInput
from app.services.access import is_loopback
from app.settings import Settings, settings_of
from app.storage.database import connect
from app.storage.key_rows import KeyRows
from app.storage.migration import require_usable

KEEP_ALIVE_S = 75
"""Longer than a phone is silent between batches, so that each goes over the connection of the one before."""
STOP_PATIENCE_S = 5
"""Listeners of events stay connected for ever; a server that stops does not wait for them."""
LOOK_EVERY_S = 0.2

app = typer.Typer(help=__doc__, add_completion=False, subcommand_metavar="")


def _help(setting: str) -> str:
    field = Settings.model_fields[setting]
    return f"{field.description} [default: {field.default}, or SUREFIX_{setting.upper()}]"


@app.callback(invoke_without_command=True)
def serve(
    host: Annotated[str | None, typer.Option(help=_help("host"))] = None,
    port: Annotated[int | None, typer.Option(help=_help("port"))] = None,
    database: Annotated[str | None, typer.Option(help=_help("database"))] = None,
    sessions: Annotated[str | None, typer.Option(help=_help("sessions"))] = None,
    workers: Annotated[int | None, typer.Option(help=_help("workers"))] = None,
) -> None:
    """Serve until stopped; prints the address once it is ready."""
    said = {"host": host, "port": port, "database": database, "sessions": sessions, "workers": workers}
    settings = settings_of({name: value for name, value in said.items() if value is not None})
    asyncio.run(refuse_unfit(settings))
    refuse_port(settings.host, settings.port)
    asyncio.run(warn_of_sessions(settings.sessions))
    if settings.workers == 1:
        _serve_alone(settings)
    else:
        _serve_together(settings)


async def refuse_unfit(settings: Settings) -> None:
    """Nothing, if the service may start like this.

    Raises
    ------
    DependencyDown : the database cannot be reached, or is not migrated.
    InvalidInput : others than this machine could reach it, and there is no API key that would be asked for.
    """
    engine = connect(settings.database)
    try:
        await require_usable(engine)
        if not is_loopback(settings.host) and not await KeyRows(engine).exist():
            raise InvalidInput(
                f"{settings.host} can be reached from other machines, and the database has no API key; make one with "
                "`surefix key create --name NAME --scope admin`, or bind to 127.0.0.1",
                "host",
            )
    finally:
        await engine.dispose()


def refuse_port(host: str, port: int) -> None:
    """Nothing, if the port is free. What else may keep the server from binding it says itself.

    Raises
    ------
    InvalidInput : it is in use, or not for this user, or nobody knows the host.
    """
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    except socket.gaierror as error:
        why = f"host {host} is not known ({error.strerror}); choose another with --host or SUREFIX_HOST"
        raise InvalidInput(why, "host") from error
    for family, kind, _, _, address in found:
        try:
            with socket.socket(family, kind) as probe:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                if family == socket.AF_INET6:
                    probe.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
                probe.bind(address)
        except OSError as error:
            state = {errno.EADDRINUSE: "is in use", errno.EACCES: "is not for this user"}.get(error.errno or 0)
            if state is not None:
                why = f"port {port} of {host} {state}; choose another with --port or SUREFIX_PORT"
                raise InvalidInput(why, "port") from error


async def warn_of_sessions(sessions: str) -> None:
    """Say on standard error that the session store cannot be reached; it may be later, while the service runs.

    Raises
    ------
    InvalidInput : the setting names no store.
    """
    from app.storage.session_state import hot_states  # brings Redis, which other commands need not wait for

    hot = hot_states(sessions, bytes, 1.0)
    try:
        await hot.ping()
    except DependencyDown as error:
        there = urlsplit(sessions)
        place = f"{there.scheme}://{there.netloc.rpartition('@')[2]}{there.path}"
        typer.echo(
            f"surefix: warning: the session store {place} cannot be reached ({error.__cause__}); "
            "batches are refused (503) until it can",
            err=True,
        )
    finally:
        await hot.close()


class _AnnouncingServer(uvicorn.Server):
    """Says where it is once it accepts requests."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self.started:
            _announce(self.config.host, self.servers[0].sockets[0].getsockname()[1])


def _serve_alone(settings: Settings) -> None:
    from app.main import create_app  # takes a second, which a refusal need not wait for

    config = uvicorn.Config(create_app(settings), host=settings.host, port=settings.port, **_uvicorn_options())
    server = _AnnouncingServer(config)
    try:
        server.run()
    except KeyboardInterrupt:
        return  # uvicorn has shut down and passes the signal on


def _serve_together(settings: Settings) -> None:
    """Several processes on one port; each makes the application from the environment."""
    from app.api.metrics import SHARED_FOLDER  # brings the web framework, see above

    port = settings.port or _free_port(settings.host)
    chosen = settings.model_copy(update={"port": port})
    with tempfile.TemporaryDirectory(prefix="surefix-metrics-") as folder:
        os.environ[SHARED_FOLDER] = folder
        os.environ |= {f"SUREFIX_{name.upper()}": str(value) for name, value in chosen.model_dump().items()}
        threading.Thread(target=_announce_when_ready, args=(settings.host, port), daemon=True).start()
        uvicorn.run(
            "app.main:create_app",
            factory=True,
            host=settings.host,
            port=port,
            workers=settings.workers,
            **_uvicorn_options(),
        )


def _uvicorn_options() -> dict[str, Any]:
    return {
        "log_level": "warning",
        "access_log": False,
        "server_header": False,
        "timeout_keep_alive": KEEP_ALIVE_S,
        "timeout_graceful_shutdown": STOP_PATIENCE_S,
    }


def _announce_when_ready(host: str, port: int) -> None:
    here = "127.0.0.1" if host == "0.0.0.0" else "::1" if host == "::" else host
    with httpx.Client(base_url=_address(here, port), trust_env=False) as client:
        while True:
            time.sleep(LOOK_EVERY_S)
            try:
                if client.get("/healthz").is_success:
                    break
            except httpx.HTTPError:
                continue
    _announce(host, port)


def _announce(host: str, port: int) -> None:
    typer.echo(f"Surefix is ready at {_address(host, port)}/")


def _address(host: str, port: int) -> str:
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


def _free_port(host: str) -> int:
    with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
        probe.bind((host, 0))
        return int(probe.getsockname()[1])
