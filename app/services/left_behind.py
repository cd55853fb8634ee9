"""Folders in the temporary directory of processes that were ended in the middle of their work: nobody else removes
them, and a survey's is as large as the survey."""

from __future__ import annotations

import asyncio
import logging
import shutil
import tempfile
import time
from enum import StrEnum
from pathlib import Path

ABANDONED_S = 86_400.0
"""No request or task takes so long."""
_log = logging.getLogger(__name__)


class ShortLived(StrEnum):
    """How the names of folders begin that live as long as one request or task."""

    UPLOAD = "surefix-upload-"
    SURVEY = "surefix-survey-"
    MAP = "surefix-map-"
    QUALITY = "surefix-quality-"
    GEOSUBMIT = "surefix-geosubmit-"


async def remove_left_behind() -> None:
    """Remove folders that nothing has been written into for a day."""
    await asyncio.to_thread(_remove, Path(tempfile.gettempdir()), time.time() - ABANDONED_S)


def _remove(folder: Path, before_s: float) -> None:
    for one in folder.iterdir():
        try:
            if one.name.startswith(tuple(ShortLived)) and one.is_dir() and one.stat().st_mtime < before_s:
                shutil.rmtree(one)
                _log.warning("removed %s, which a process that was ended has left behind", one.name)
        except OSError as error:  # of somebody else, or another worker was faster
            _log.info("%s stays: %s", one.name, error)
