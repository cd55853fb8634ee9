"""The wire schema of opening a session."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field, TypeAdapter, ValidationError

from app.api.json_bodies import FROM_PHONES, refusal
from app.fusion.interface import SessionStart
from app.observations import Position

Name = Annotated[str, Field(max_length=64)]
Metres = Annotated[float, Field(ge=-1e6, le=1e6, description="m")]


class DeviceBody(BaseModel):
    """What phone it is."""

    model_config = FROM_PHONES

    brand: Annotated[str | None, Field(max_length=200)] = None
    model: Annotated[str | None, Field(max_length=200)] = None


class StartBody(BaseModel):
    """A prior of 5 m (68 %); does not bind."""

    model_config = FROM_PHONES

    x: Metres
    y: Metres
    floor: Name


class SessionBody(BaseModel):
    """All but `venue` optional; unknown fields are ignored."""

    model_config = FROM_PHONES

    venue: Name
    method: Annotated[str, Field(max_length=64)] = "surefix"
    floor: Annotated[Name | None, Field(description="a hint; does not bind")] = None
    device: DeviceBody | None = None
    alert_limit: Annotated[float, Field(gt=0, le=1000, description="m")] = 10.0
    risk: Annotated[float, Field(ge=0.001, le=0.05, description="that the error exceeds the protection level")] = 0.01
    start: StartBody | None = None

    def session_start(self) -> SessionStart:
        """What the methods need of it."""
        start = None if self.start is None else Position(self.start.x, self.start.y, self.start.floor)
        return SessionStart(self.alert_limit, self.risk, self.floor, start)

    def device_names(self) -> dict[str, str] | None:
        """Brand and model as printable text: some phones pad them with NUL characters, which databases refuse."""
        if self.device is None:
            return None
        sent = {"brand": self.device.brand, "model": self.device.model}
        return {name: "".join(filter(str.isprintable, text)) for name, text in sent.items() if text is not None}


class OpenedBody(BaseModel):
    """An opened session. `created` and `expires` are by the server's clock; every batch moves `expires`."""

    session: str
    venue: str
    method: str
    created: int
    expires: int


_SESSION = TypeAdapter(SessionBody)


def parse_session(sent: bytes) -> SessionBody:
    """The session that a JSON body asks for.

    Raises
    ------
    InvalidInput : names the first offending field.
    """
    try:
        return _SESSION.validate_json(sent)
    except ValidationError as error:
        raise refusal(error) from error
