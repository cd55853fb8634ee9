from __future__ import annotations

import io
import math

import pytest

from app.errors import InvalidInput
from app.survey.rejection import Rejections
from app.survey.ujiindoorloc import (
    frame_about,
    is_ujiindoorloc,
    mercator_to_wgs84,
    read_ujiindoorloc,
    uji_address,
)

HEADER = "WAP001,WAP002,WAP003,LONGITUDE,LATITUDE,FLOOR,BUILDINGID,SPACEID,RELATIVEPOSITION,USERID,PHONEID,TIMESTAMP\n"
GOOD = "-60,100,-97,-7541.2643,4864920.7782,2,1,106,2,2,23,1371713733\n"


def test_a_row_is_a_scan_of_the_access_points_that_were_heard() -> None:
    (scan,) = read_ujiindoorloc(io.StringIO(HEADER + GOOD), Rejections())
    assert (scan.row, scan.floor, scan.level, scan.time_ms) == (2, "B1F2", 2, 1371713733000)
    assert scan.readings == ((1, -60.0), (3, -97.0))
    assert uji_address(3) == "02:00:00:00:00:03"


def test_mercator_metres_become_metres_on_the_ground() -> None:
    place, east, north = (mercator_to_wgs84(-7541.0 + x, 4864920.0 + y) for x, y in ((0, 0), (100, 0), (0, 100)))
    assert place == pytest.approx((39.9925, -0.06774), abs=1e-3)
    frame, width_m, height_m = frame_about([place, east, north], 10.0)
    ground = math.cos(math.radians(place[0]))
    assert ground == pytest.approx(0.766, abs=5e-4)
    assert frame.to_local(*place) == pytest.approx((10.0, 10.0), abs=1e-3)
    assert frame.to_local(*east) == pytest.approx((10.0 + 100 * ground, 10.0), rel=2e-3)
    assert frame.to_local(*north) == pytest.approx((10.0, 10.0 + 100 * ground), rel=2e-3)
    assert (width_m, height_m) == pytest.approx((96.6, 96.6), abs=0.3)


@pytest.mark.parametrize(
    "bad",
    [
        "1,2\n",
        GOOD.replace("-60", "x"),
        GOOD.replace("4864920", "9e99"),
        GOOD.replace(",2,1,", ",a,1,"),
        GOOD.replace(",2,1,", ",inf,1,"),
    ],
)
def test_a_bad_row_is_rejected_by_its_number(bad: str) -> None:
    rejections = Rejections()
    assert len(list(read_ujiindoorloc(io.StringIO(HEADER + GOOD + bad + GOOD), rejections))) == 2
    assert [one.item for one in rejections.listed] == [3]


def test_the_header_tells_the_layout_and_must_be_whole() -> None:
    assert is_ujiindoorloc(b'\xef\xbb\xbf"WAP001","WAP002"') and not is_ujiindoorloc(b"floor,x,y")
    with pytest.raises(InvalidInput, match="TIMESTAMP are missing"):
        list(read_ujiindoorloc(io.StringIO("WAP001,LONGITUDE,LATITUDE,FLOOR,BUILDINGID\n"), Rejections()))
