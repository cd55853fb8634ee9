from __future__ import annotations

import asyncio
import os
import resource
import signal
import sqlite3
import sys
import time
from collections.abc import Awaitable, Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import orjson
import pytest

from app.errors import DependencyDown, InvalidInput
from app.services.surveys import Receipt
from app.services.tasks import HEARTBEAT_S, LOST_MS, Tasks, TaskState, TaskStatus
from app.services.worker_processes import WorkerProcesses
from app.storage.database import BUSY_S
from app.storage.task_rows import TaskRow, TaskRows
from app.survey.admission import FloorExtent
from app.survey.upload import SurveyFormat, Upload, read_upload
from app.wifi.radio_map_codec import decode_radio_map
from tests.api.survey_service import CLOCK_MS, Wired, make_venue, wire
from tests.survey.traces import mac, walk

HEADER = "floor,x,y,t,bssid,rssi\n"
FLOORS = {"F1": FloorExtent("F1", 100.0, 60.0)}


def with_service(tmp_path: Path, workers: WorkerProcesses, use: Callable[[Wired], Awaitable[Any]]) -> Any:
    """What a coroutine function gives, on the services over a new database."""

    async def run() -> Any:
        wired = wire(f"sqlite:///{tmp_path / 'surveys.db'}", workers)
        await make_venue(wired.engine)
        try:
            return await use(wired)
        finally:
            await wired.engine.dispose()

    return asyncio.run(run())


def csv_upload(path: Path, number: int = 1) -> Upload:
    """A survey of one fingerprint."""
    path.write_text(f"{HEADER}F1,{number},2,{CLOCK_MS},{mac(number)},-50\n")
    return Upload(SurveyFormat.CSV, ((path.name, path),))


def test_those_who_publish_at_once_get_numbers_of_their_own_and_the_last_map_holds_all(
    tmp_path: Path, workers: WorkerProcesses
) -> None:
    uploads = [csv_upload(tmp_path / f"{number}.csv", number) for number in range(1, 9)]

    async def use(wired: Wired) -> None:
        receipts: list[Receipt] = await asyncio.gather(*(wired.surveys.add("mall", one, True) for one in uploads))
        assert sorted(one.version or 0 for one in receipts) == list(range(1, 9))
        assert len({one.survey for one in receipts}) == 8
        active = await wired.map_rows.active("mall")
        assert active is not None and active.body is not None
        radio_map = decode_radio_map(active.body)
        assert (active.version, radio_map.version, len(radio_map.bssid)) == (8, 8, 8)
        for version in await wired.radio_maps.listed("mall"):
            assert len(version.surveys) == version.version

    with_service(tmp_path, workers, use)


def test_two_services_over_one_database_publish_without_losing_a_survey(
    tmp_path: Path, workers: WorkerProcesses
) -> None:
    uploads = [csv_upload(tmp_path / f"{number}.csv", number) for number in range(1, 5)]

    async def use(wired: Wired) -> None:
        other = wire(str(wired.engine.url).replace("+aiosqlite", ""), workers)
        services = (wired.surveys, other.surveys)
        adding = (services[at % 2].add("mall", one, True) for at, one in enumerate(uploads))
        receipts: list[Receipt] = await asyncio.gather(*adding)
        await other.engine.dispose()
        assert sorted(one.version or 0 for one in receipts) == [1, 2, 3, 4]
        versions = await wired.radio_maps.listed("mall")
        assert sorted(versions[-1].surveys) == sorted(one.survey for one in receipts)

    with_service(tmp_path, workers, use)


def test_a_worker_that_dies_leaves_nothing_and_the_next_upload_gets_another(tmp_path: Path) -> None:
    workers = WorkerProcesses(1)

    async def use(wired: Wired) -> None:
        with pytest.raises(DependencyDown, match="worker process died"):
            await workers.run(os.kill, await workers.run(os.getpid), signal.SIGKILL)
        assert await wired.survey_rows.ids(1) == []
        receipt = await wired.surveys.add("mall", csv_upload(tmp_path / "a.csv"), True)
        assert (receipt.accepted, receipt.version) == (1, 1)

    try:
        with_service(tmp_path, workers, use)
    finally:
        workers.stop()


def test_a_refusal_keeps_its_field_on_the_way_from_the_worker(tmp_path: Path, workers: WorkerProcesses) -> None:
    path = tmp_path / "a.csv"
    path.write_text(HEADER.replace("rssi", "colour"))

    async def use(wired: Wired) -> None:
        with pytest.raises(InvalidInput) as refused:
            await wired.surveys.add("mall", Upload(SurveyFormat.CSV, (("a", path),)), False)
        assert refused.value.field == "rssi"

    with_service(tmp_path, workers, use)


def test_the_event_loop_stays_free_while_a_large_survey_is_read(tmp_path: Path, workers: WorkerProcesses) -> None:
    files = []
    for number in range(12):
        files.append((f"{number}.txt", tmp_path / f"{number}.txt"))
        files[-1][1].write_bytes(walk(seconds=90))

    async def use(wired: Wired) -> None:
        await workers.run(read_upload, Upload(SurveyFormat.TRACES, tuple(files[:1]), "F1"), FLOORS, tmp_path / "spool")
        adding = asyncio.create_task(wired.surveys.add("mall", Upload(SurveyFormat.TRACES, tuple(files), "F1"), True))
        turns = 0
        used_s = time.thread_time()
        while not adding.done():
            await asyncio.wait([adding], timeout=0.002)
            turns += 1
        used_s = time.thread_time() - used_s
        assert (await adding).accepted > 500
        # how long a turn takes is the machine's affair; how much of the loop's own time went into it is ours
        assert used_s < 0.5 and turns > 20

    with_service(tmp_path, workers, use)


def large_csv(path: Path, places: int, per_place: int) -> int:
    """Writes a CSV of many readings; gives its size in bytes."""
    with path.open("w") as file:
        file.write(HEADER)
        for place in range(places):
            where = f"F1,{place % 100},{place % 60},{CLOCK_MS + place},"
            file.writelines(f"{where}{mac(number)},{-30 - number % 60}\n" for number in range(per_place))
    return path.stat().st_size


def peak_growth_bytes(function: str, *arguments: str) -> int:
    """How much memory a function of this module takes in a process of its own, above what its imports take."""

    async def measure() -> int:
        program = f"from {__name__} import {function}; {function}({', '.join(map(repr, arguments))})"
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-c", program, cwd=Path(__file__).parents[2], stdout=asyncio.subprocess.PIPE
        )
        out, _ = await process.communicate()
        assert process.returncode == 0
        return int(out)

    return asyncio.run(measure())


def read_and_print_growth(source: str, kind: str, spool: str) -> None:
    """Reads an upload and prints by how many bytes the peak of this process rose."""
    upload = Upload(SurveyFormat(kind), (("walk.txt", Path(source)),), "F1")
    small = Path(source).with_suffix(".small")
    read_upload(Upload(SurveyFormat(kind), (("small.txt", small),), "F1"), FLOORS, Path(spool))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    read_upload(upload, FLOORS, Path(spool))
    print(1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before))


@pytest.mark.parametrize("kind", ["csv", "json", "traces"])
def test_reading_a_large_upload_takes_far_less_memory_than_the_upload(tmp_path: Path, kind: str) -> None:
    source = tmp_path / "large"
    if kind == "csv":
        size = large_csv(source, places=2500, per_place=200)
        large_csv(source.with_suffix(".small"), places=3, per_place=200)
    elif kind == "json":
        readings = ",".join(f'{{"bssid":"{mac(n)}","rssi":-50,"frequency":2412,"ssid":"shop"}}' for n in range(200))
        one = f'{{"x":1,"y":2,"t":{CLOCK_MS},"readings":[{readings}]}}'
        for path, count in ((source, 2000), (source.with_suffix(".small"), 2)):
            path.write_text(f'{{"floor":"F1","fingerprints":[{",".join([one] * count)}]}}')
        size = source.stat().st_size
    else:
        source.write_bytes(walk(seconds=6000))
        source.with_suffix(".small").write_bytes(walk(seconds=10))
        size = source.stat().st_size
    grown = peak_growth_bytes("read_and_print_growth", str(source), kind, str(tmp_path / "spool"))
    assert size > 15_000_000
    # rows of a table are read one by one; a walk is placed as a whole, as packed numbers
    assert grown < (0.9 * size + 60_000_000 if kind == "traces" else 12_000_000)


def store_and_print_growth(folder: str) -> None:
    """Stores an upload and prints by how many bytes the peak of this process, which is not the one that reads, rose."""
    workers = WorkerProcesses(1)

    async def use(wired: Wired) -> None:
        await wired.surveys.add("mall", csv_upload(Path(folder) / "small.csv"), False)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        upload = Upload(SurveyFormat.CSV, (("large.csv", Path(folder) / "large.csv"),))
        assert (await wired.surveys.add("mall", upload, False)).accepted == 3000
        print(1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before))

    with_service(Path(folder), workers, use)
    workers.stop()


def test_storing_a_large_survey_takes_no_memory_to_speak_of(tmp_path: Path) -> None:
    assert large_csv(tmp_path / "large.csv", places=3000, per_place=200) > 20_000_000
    assert peak_growth_bytes("store_and_print_growth", str(tmp_path)) < 15_000_000


def test_a_task_whose_worker_is_gone_is_told_as_failed(tmp_path: Path, workers: WorkerProcesses) -> None:
    lost = 22 * "x"

    async def use(wired: Wired) -> None:
        await TaskRows(wired.engine).add(TaskRow(lost, "running", CLOCK_MS, CLOCK_MS, None), 0)
        assert (await wired.tasks.state(lost)).status is TaskStatus.RUNNING
        wired.clock_ms[0] = CLOCK_MS + LOST_MS + 1
        state = await wired.tasks.state(lost)
        assert (state.status, state.outcome) == (TaskStatus.FAILED, None)
        assert 1000 * HEARTBEAT_S * 3 < LOST_MS

    with_service(tmp_path, workers, use)


def test_tasks_that_are_stopped_or_break_are_told_as_failed(tmp_path: Path, workers: WorkerProcesses) -> None:
    async def use(wired: Wired) -> None:
        tasks: Tasks = wired.tasks

        async def for_ever() -> bytes:
            await asyncio.Event().wait()
            raise AssertionError("nobody sets it")

        async def broken() -> bytes:
            raise RuntimeError("of the inside")

        name, other = await tasks.start(broken), await tasks.start(for_ever)
        await asyncio.wait(tasks.running, return_when=asyncio.FIRST_COMPLETED)
        state = await tasks.state(name)
        assert state.status is TaskStatus.FAILED and state.outcome is not None
        assert orjson.loads(state.outcome)["status"] == 500 and b"inside" not in state.outcome
        assert (await tasks.state(other)).status is TaskStatus.RUNNING
        await tasks.close()
        assert (await tasks.state(other)).status is TaskStatus.FAILED

    with_service(tmp_path, workers, use)


def test_what_was_done_while_the_database_was_away_is_told_as_done(
    tmp_path: Path, workers: WorkerProcesses, caplog: pytest.LogCaptureFixture
) -> None:
    async def use(wired: Wired) -> None:
        with closing(sqlite3.connect(tmp_path / "surveys.db", isolation_level=None)) as other:

            async def done_as_it_goes_away() -> bytes:
                other.execute("BEGIN EXCLUSIVE")
                return b"{}"

            name = await wired.tasks.start(done_as_it_goes_away)
            await asyncio.wait(wired.tasks.running, timeout=2.0 * BUSY_S)
            assert wired.tasks.running and "told later" in caplog.text
            other.execute("ROLLBACK")
            await asyncio.wait(wired.tasks.running)
        assert await wired.tasks.state(name) == TaskState(name, TaskStatus.DONE, b"{}")

    with_service(tmp_path, workers, use)


def test_fingerprints_of_other_venues_stay_out_of_a_map(tmp_path: Path, workers: WorkerProcesses) -> None:
    async def use(wired: Wired) -> None:
        await make_venue(wired.engine, "station")
        await wired.surveys.add("station", csv_upload(tmp_path / "a.csv", 1), True)
        await wired.surveys.add("mall", csv_upload(tmp_path / "b.csv", 2), True)
        for venue, number in (("station", 1), ("mall", 2)):
            active = await wired.map_rows.active(venue)
            assert active is not None and active.body is not None
            assert decode_radio_map(active.body).bssid.tolist() == [0x020000000000 + number]

    with_service(tmp_path, workers, use)
