"""The wire schemas of surveys; app/survey reads the bodies themselves, which are too large to be held whole."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field

from app.api.examples import SURVEY
from app.services.surveys import Receipt


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


_FILES = {"type": "array", "items": {"type": "string", "format": "binary"}}
REQUEST = {
    "requestBody": {
        "required": True,
        "content": {
            "application/json": {
                "example": SURVEY,
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
                },
            },
            "text/csv": {
                "schema": {
                    "type": "string",
                    "description": "floor,x,y,t,bssid,rssi[,frequency][,ssid], a reading a line",
                }
            },
            "multipart/form-data": {
                "schema": {"type": "object", "required": ["files"], "properties": {"files": _FILES}}
            },
        },
    }
}


def receipt_body(receipt: Receipt) -> ReceiptBody:
    """A receipt as it is answered."""
    return ReceiptBody(
        survey=receipt.survey,
        accepted=receipt.accepted,
        rejected=[RejectionBody(item=one.item, reason=one.reason) for one in receipt.rejected],
        rejected_count=receipt.rejected_count,
        version=receipt.version,
    )
