from __future__ import annotations

import socket

from app.commands.demo import _free_port


def test_the_port_that_is_asked_for_is_taken_where_it_is_free() -> None:
    free = _free_port(0)
    assert _free_port(free) == free


def test_another_port_is_taken_where_that_is_in_use() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        used = other.getsockname()[1]
        assert _free_port(used) not in (used, 0)
