"""The folder that a command writes to, made before the work whose results it is for."""

from __future__ import annotations

from pathlib import Path

from app.errors import InvalidInput


def make_folder(folder: Path, option: str = "out") -> None:
    """Make the folder that an option names, and those above it, where they are missing.

    Raises
    ------
    InvalidInput : it is a file, or cannot be made; names the option.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(
            f"{option}: no folder can be made at {folder} ({error.strerror}); name another", option
        ) from error
