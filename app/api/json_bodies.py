"""JSON bodies that routes read themselves: their rules, their description, their parsing and how it refuses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import orjson
from fastapi import Request
from pydantic import BaseModel, ConfigDict, ValidationError

from app.api.decoding import Packing, packing_of, read_body
from app.errors import InvalidInput, TooLarge, UnsupportedMedia

FROM_PHONES = ConfigDict(strict=True, allow_inf_nan=False, extra="ignore")
"""Unknown fields are of newer phones."""
FROM_ADMINISTRATORS = ConfigDict(strict=True, allow_inf_nan=False, extra="forbid")
"""An unknown field is a mistake."""
Body = TypeVar("Body", bound=BaseModel)


def request_body(
    body: type[BaseModel] | Mapping[str, Any], *media_types: str, example: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """What the API page says of a body.

    Parameters
    ----------
    body : its model or schema.  media_types : JSON unless others are named.  example : as JSON.
    """
    schema = inlined_schema(body) if isinstance(body, type) else body
    content: dict[str, Any] = {kind: {"schema": schema} for kind in media_types or (Packing.JSON,)}
    if example is not None:
        content[Packing.JSON]["example"] = example
    return {"requestBody": {"required": True, "content": content}}


def inlined_schema(model: type[BaseModel]) -> dict[str, Any]:
    """The JSON schema of a model without references, for bodies that FastAPI does not parse itself."""
    schema = model.model_json_schema()
    definitions = schema.pop("$defs", {})

    def inlined(node: Any) -> Any:
        if isinstance(node, list):
            return [inlined(child) for child in node]
        if not isinstance(node, dict):
            return node
        if "$ref" in node:
            target = definitions[node["$ref"].rpartition("/")[2]]
            return inlined({**target, **{key: value for key, value in node.items() if key != "$ref"}})
        return {key: inlined(value) for key, value in node.items()}

    return dict(inlined(schema))


async def read_json(request: Request, limit_bytes: int) -> bytes:
    """The body of a request that may only be JSON, not parsed yet.

    Raises
    ------
    UnsupportedMedia : it says that it is something else.
    InvalidInput, TooLarge : as read_body does.
    """
    if packing_of(request.headers.get("content-type")) is not Packing.JSON:
        raise UnsupportedMedia("this is read as application/json")
    return await read_body(request, limit_bytes)


def parse_admin(model: type[Body], sent: bytes) -> Body:
    """The body of an administrator's request.

    Raises
    ------
    InvalidInput : not JSON, or not such a body; names the first offending field.
    """
    try:
        return model.model_validate(orjson.loads(sent))
    except orjson.JSONDecodeError as error:
        raise InvalidInput(f"the body is not JSON: {error}") from error
    except ValidationError as error:
        raise refusal(error) from error


def refusal(error: ValidationError) -> InvalidInput:
    """The first finding of a validation, as the error of this service; never the input itself, which may be large."""
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    kind = TooLarge if first["type"] == "too_long" else InvalidInput
    return kind(first["msg"], field_path(first["loc"]))


def field_path(location: Sequence[int | str]) -> str:
    """`("wifi", 0, "t")` as `wifi[0].t`."""
    path = ""
    for part in location:
        path += f"[{part}]" if isinstance(part, int) else f".{part}" if path else part
    return path
