from __future__ import annotations

import asyncio
import gzip
import random
import time
from typing import Any

import pytest
import zstandard
from fastapi import Request
from hypothesis import given
from hypothesis import strategies as st

from app.api.decoding import MOST_MEMBERS, Packing, decompress, packing_of, prefers, read_body
from app.errors import InvalidInput, TooLarge, UnsupportedMedia

LIMIT = 1000


@given(st.binary(max_size=LIMIT))
def test_what_was_compressed_comes_back(plain: bytes) -> None:
    assert decompress(plain, "", LIMIT) == plain
    assert decompress(gzip.compress(plain), "gzip", LIMIT) == plain
    assert decompress(zstandard.compress(plain), "zstd", LIMIT) == plain
    half = len(plain) // 2
    assert decompress(gzip.compress(plain[:half]) + gzip.compress(plain[half:]), "gzip", LIMIT) == plain
    assert decompress(zstandard.compress(plain[:half]) + zstandard.compress(plain[half:]), "zstd", LIMIT) == plain


@pytest.mark.parametrize("encoding", ["gzip", "zstd"])
def test_a_bomb_is_refused(encoding: str) -> None:
    plain = b"\0" * 50_000_000
    sent = gzip.compress(plain) if encoding == "gzip" else zstandard.compress(plain)
    with pytest.raises(TooLarge):
        decompress(sent, encoding, 1_000_000)


@pytest.mark.parametrize("count", [MOST_MEMBERS, MOST_MEMBERS + 1])
def test_a_gzip_body_may_have_many_members_but_not_any_number(count: int) -> None:
    sent = gzip.compress(b"x") + (count - 1) * gzip.compress(b"")
    if count <= MOST_MEMBERS:
        assert decompress(sent, "gzip", LIMIT) == b"x"
    else:
        with pytest.raises(InvalidInput, match="members"):
            decompress(sent, "gzip", LIMIT)


def test_a_gzip_member_longer_than_a_piece_comes_back() -> None:
    plain = random.Random(7).randbytes(300_000)
    assert decompress(gzip.compress(plain) + gzip.compress(plain), "gzip", 600_000) == plain + plain


@pytest.mark.parametrize("encoding", ["gzip", "zstd"])
def test_the_event_loop_stays_free_while_a_large_body_is_decompressed(encoding: str) -> None:
    plain = b"".join(b"%d," % number for number in range(2_000_000))
    sent = gzip.compress(plain, 1) if encoding == "gzip" else zstandard.compress(plain, 1)

    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": sent, "more_body": False}

    async def read() -> None:
        headers = [(b"content-encoding", encoding.encode())]
        request = Request({"type": "http", "method": "POST", "headers": headers}, receive)
        of_loop_s, of_all_s = time.thread_time(), time.process_time()
        read = await read_body(request, len(plain))
        of_loop_s, of_all_s = time.thread_time() - of_loop_s, time.process_time() - of_all_s
        assert of_loop_s < 0.3 * of_all_s
        assert read == plain

    asyncio.run(read())


def test_a_zstd_frame_that_asks_for_a_huge_window_is_refused() -> None:
    settings = zstandard.ZstdCompressionParameters(window_log=27, enable_ldm=True)
    compressor = zstandard.ZstdCompressor(compression_params=settings).compressobj()
    with pytest.raises(InvalidInput):
        decompress(compressor.compress(b"x" * 100) + compressor.flush(), "zstd", LIMIT)


@given(st.binary(min_size=1, max_size=100), st.sampled_from(["gzip", "zstd"]))
def test_damaged_data_are_refused_or_read_but_nothing_else(sent: bytes, encoding: str) -> None:
    try:
        decompress(sent, encoding, LIMIT)
    except InvalidInput as refusal:
        assert encoding in str(refusal)


@pytest.mark.parametrize("encoding", ["br", "deflate", "gzip, zstd", "x"])
def test_other_encodings_are_refused(encoding: str) -> None:
    with pytest.raises(UnsupportedMedia):
        decompress(b"", encoding, LIMIT)


@pytest.mark.parametrize(
    ("content_type", "packing"),
    [
        (None, Packing.JSON),
        ("application/json", Packing.JSON),
        ("Application/JSON; charset=utf-8", Packing.JSON),
        ("application/msgpack", Packing.MSGPACK),
        ("application/x-msgpack", Packing.MSGPACK),
    ],
)
def test_the_layout_is_told_from_the_content_type(content_type: str | None, packing: Packing) -> None:
    assert packing_of(content_type) is packing


@pytest.mark.parametrize(
    ("accept", "given"),
    [
        ("application/geo+json", True),
        ("APPLICATION/GEO+JSON;Q=0.1", True),
        ("text/html, application/geo+json ; charset=utf-8 ; q=1.000", True),
        ("application/geo+json;q=0.9, application/json;q=0.9", True),
        ("application/geo+json;q=junk", True),
        ("application/geo+json;q=0", False),
        ("application/geo+json; q=0.000, */*", False),
        ("application/geo+json;q=0.5, application/json", False),
        ("application/geo+jsonx", False),
        ("*/*", False),
        ("", False),
    ],
)
def test_a_media_type_is_given_where_it_is_named_with_weight_and_the_other_has_no_more(
    accept: str, given: bool
) -> None:
    assert prefers(accept, "application/geo+json", "application/json") is given


@pytest.mark.parametrize("content_type", ["text/plain", "application/x-www-form-urlencoded", "x"])
def test_other_media_types_are_refused(content_type: str) -> None:
    with pytest.raises(UnsupportedMedia):
        packing_of(content_type)
