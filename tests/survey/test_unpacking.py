from __future__ import annotations

import bz2
import gzip
import io
import lzma
import zipfile

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.errors import InvalidInput, TooLarge
from app.survey.trace import read_trace, read_traces
from app.survey.unpacking import Allowance, damage_named, unpacked
from tests.survey.traces import walk

WALK = walk(seconds=4)


def zipped(files: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return buffer.getvalue()


def contents(sent: bytes, allowance: Allowance | None = None) -> dict[str, bytes]:
    found = {}
    for name, stream in unpacked(io.BytesIO(sent), "sent", allowance or Allowance()):
        with damage_named(name):
            found[name] = stream.read()
    return found


@pytest.mark.parametrize(
    "packed",
    [
        WALK,
        gzip.compress(WALK),
        lzma.compress(WALK),
        gzip.compress(WALK[:1000]) + gzip.compress(WALK[1000:]),
        lzma.compress(WALK[:1000]) + lzma.compress(WALK[1000:]) + b"\0" * 8,
        zipped({"a.txt": WALK}),
        zipped({"folder/a.txt.xz": lzma.compress(WALK), "__MACOSX/._a.txt": b"x", "folder/.DS_Store": b"x"}),
        zipped({"a.txt.gz": gzip.compress(WALK)}, zipfile.ZIP_LZMA),
    ],
    ids=["plain", "gzip", "xz", "gzip members", "xz streams", "zip", "zip of xz with rubbish", "lzma zip of gzip"],
)
def test_the_content_tells_how_a_file_is_packed(packed: bytes) -> None:
    assert (
        read_trace(packed, "a.dat").accelerometer.values.tolist() == read_trace(WALK, "a").accelerometer.values.tolist()
    )


def test_every_file_of_a_zip_is_read_under_its_own_name() -> None:
    packed = zipped({"F1/one.txt": WALK, "F1/two.txt.xz": lzma.compress(WALK)})
    assert [trace.trace for trace in read_traces(packed, "all.zip")] == ["one", "two"]


@pytest.mark.parametrize("pack", [gzip.compress, lzma.compress, lambda plain: zipped({"a": plain})])
@pytest.mark.parametrize("kept", [0.3, 0.9, 0.999])
def test_a_file_that_is_cut_short_is_refused_by_name(pack: object, kept: float) -> None:
    packed = pack(WALK)  # type: ignore[operator]
    with pytest.raises(InvalidInput, match=r"sent|a\b"):
        contents(packed[: int(kept * len(packed))])


@settings(deadline=None)
@given(st.sampled_from([gzip.compress(WALK), lzma.compress(WALK), zipped({"a": WALK})]), st.data())
def test_no_flipped_byte_gets_past_the_check_or_raises_anything_but_a_refusal(
    packed: bytes, data: st.DataObject
) -> None:
    at, flip = data.draw(st.integers(0, len(packed) - 1)), data.draw(st.integers(1, 255))
    damaged = packed[:at] + bytes([packed[at] ^ flip]) + packed[at + 1 :]
    try:
        found = contents(damaged)
    except InvalidInput:
        return
    # what no checksum covers: a name, a date; or the magic number, and then it is not taken for an archive
    assert set(found.values()) <= {WALK, damaged}


def test_an_encrypted_zip_and_a_zip_in_a_zip_are_refused() -> None:
    with pytest.raises(InvalidInput, match="zip inside a zip"):
        contents(zipped({"inner.zip": zipped({"a": WALK})}))
    locked = bytearray(zipped({"a": WALK}))
    locked[6] |= 1
    locked[locked.rfind(b"PK\x01\x02") + 8] |= 1
    with pytest.raises(InvalidInput, match="encrypted"):
        contents(bytes(locked))


def test_a_zip_by_an_unknown_method_is_refused() -> None:
    packed = bytearray(zipped({"a": WALK}, zipfile.ZIP_STORED))
    packed[8] = packed[packed.rfind(b"PK\x01\x02") + 10] = 97
    with pytest.raises(InvalidInput, match="damaged"):
        contents(bytes(packed))


@pytest.mark.parametrize(
    "pack", [gzip.compress, lzma.compress, lambda plain: zipped({"a": plain}), lambda plain: plain]
)
def test_a_bomb_is_stopped_at_the_limit_of_a_file(pack: object) -> None:
    with pytest.raises(TooLarge, match="after decompression"):
        contents(pack(b"\0" * 3_000_000), Allowance(file_bytes=1_000_000))  # type: ignore[operator]


def test_a_bomb_of_many_files_is_stopped_at_the_limit_of_all() -> None:
    allowance = Allowance(file_bytes=1_000_000, left_bytes=2_500_000)
    bomb = zipped({str(number): b"\0" * 900_000 for number in range(20)})
    with pytest.raises(TooLarge):
        contents(bomb, allowance)
    assert allowance.left_bytes > -1_000_000


def test_xz_may_not_ask_for_a_gigabyte_of_memory() -> None:
    filters = [{"id": lzma.FILTER_LZMA2, "preset": 0, "dict_size": 1 << 30}]
    with pytest.raises(InvalidInput, match="damaged"):
        contents(lzma.compress(WALK, filters=filters))


def test_a_format_that_is_not_known_is_plain_bytes_and_no_trace() -> None:
    with pytest.raises(InvalidInput, match="not a trace"):
        read_trace(bz2.compress(WALK), "a.bz2")
