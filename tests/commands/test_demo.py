from __future__ import annotations

import socket
from pathlib import Path

import pytest

from app.commands.demo import _free_port
from tests.commands.surefix_process import surefix


def test_the_port_that_is_asked_for_is_taken_where_it_is_free() -> None:
    free = _free_port(0)
    assert _free_port(free) == free


def test_another_port_is_taken_where_that_is_in_use() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        used = other.getsockname()[1]
        assert _free_port(used) not in (used, 0)


@pytest.mark.parametrize(
    ("option", "word"), [(("--building", "castle"), "hospital"), (("--database", "mysql://x"), "sqlite:///path")]
)
def test_a_demo_that_cannot_be_is_refused_before_a_server_is_started(
    tmp_path: Path, option: tuple[str, str], word: str
) -> None:
    refused = surefix("demo", "--seconds", "1", "--port", "0", *option, folder=tmp_path)
    assert refused.returncode == 2 and word in refused.stderr
    assert "Starting the server" not in refused.stderr and "Traceback" not in refused.stderr
    assert list(tmp_path.iterdir()) == []
