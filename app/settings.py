"""Settings of the service, read from environment variables SUREFIX_* and validated once at start.

Every default of the command line comes from here.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, ValidationError
from pydantic_settings import BaseSettings, SettingsConfigDict

from app.errors import InvalidInput


class Settings(BaseSettings):
    """One attribute a setting; the description says what it costs to change it."""

    model_config = SettingsConfigDict(env_prefix="SUREFIX_", extra="ignore")

    host: str = Field(
        "127.0.0.1", description="Address to bind. Anything but loopback needs an API key in the database."
    )
    port: int = Field(8000, ge=0, le=65535, description="Port to bind; 0 lets the system choose.")
    workers: int = Field(1, ge=1, le=64, description="Server processes.")
    database: str = Field("sqlite:///surefix.db", description="sqlite:///path or postgresql://user:password@host/name.")
    sessions: str = Field("memory", description="Where hot session state lives: memory or redis://host:port/db.")
    session_hours: Annotated[float, Field(gt=0, le=24 * 30)] = 12.0
    """Hours of the server's clock after its last batch at which a session expires."""
    batch_limit_bytes: int = Field(16_000_000, ge=10_000, description="Largest batch body, after decompression.")
    survey_limit_bytes: int = Field(2_000_000_000, ge=1_000_000, description="Largest survey body, as sent.")
    watch_sessions: int = Field(
        3, ge=1, le=1000, description="Distinct sessions that must exclude an access point before it is watched."
    )
    watch_hours: Annotated[float, Field(gt=0, le=24 * 30)] = 24.0
    """Hours for which a session's exclusion of an access point counts, and its confirmation."""
    watch_share: float = Field(
        0.25, ge=0, le=1, description="Share of the sessions with a say that must exclude an access point."
    )


def settings_of(said: Mapping[str, Any]) -> Settings:
    """The settings, with what the command line says instead of the environment.

    Raises
    ------
    InvalidInput : names the option or the variable of the first setting that is not possible.
    """
    try:
        return Settings(**said)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        name = ".".join(map(str, first["loc"]))
        source = f"--{name}" if name in said else f"SUREFIX_{name.upper()}"
        raise InvalidInput(f"{source}: {first['msg']}", name) from error
