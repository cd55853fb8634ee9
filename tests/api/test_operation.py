from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from app.main import create_app
from app.settings import Settings
from app.storage.migration import migrate
from tests.api.whole_service import database_in, whole_service
from tests.redis_process import RedisProcess


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with whole_service(tmp_path_factory.mktemp("operation")) as made:
        made.post("/v1/venues", json={"venue": "mall"})
        yield made


def figures(client: TestClient) -> dict[str, float]:
    """Every series with its value."""
    lines = client.get("/metrics").text.splitlines()
    pairs = (line.rpartition(" ") for line in lines if not line.startswith("#"))
    return {name: float(value) for name, _, value in pairs}


def risen(before: dict[str, float], after: dict[str, float]) -> dict[str, float]:
    """What counts have risen, and by how much."""
    counts = {name: after[name] - before.get(name, 0.0) for name in after if re.search(r"_(total|count)\b", name)}
    return {name: rise for name, rise in counts.items() if rise and "/metrics" not in name and "cpu" not in name}


def test_a_service_with_its_stores_is_alive_and_ready(client: TestClient) -> None:
    assert client.get("/healthz").json() == {"status": "ok"}
    assert client.get("/readyz").json() == {"status": "ready"}
    assert [client.head(path).status_code for path in ("/healthz", "/readyz", "/")] == [200] * 3


def test_a_path_with_a_slash_too_many_is_not_found(client: TestClient) -> None:
    answer = client.delete("/v1/sessions/", follow_redirects=False)
    assert (answer.status_code, answer.headers["content-type"]) == (404, "application/problem+json")


def test_a_database_without_tables_is_not_ready_and_the_service_says_what_to_do(tmp_path: Path) -> None:
    with TestClient(create_app(Settings(database=database_in(tmp_path))), raise_server_exceptions=False) as client:
        assert client.get("/healthz").status_code == 200
        answer = client.get("/readyz")
        assert answer.status_code == 503 and int(answer.headers["retry-after"]) > 0
        assert "surefix migrate" in answer.json()["detail"]
        migrate(database_in(tmp_path))
        assert client.get("/readyz").status_code == 200


def test_while_the_session_store_is_away_the_service_is_alive_but_not_ready(tmp_path: Path) -> None:
    redis = RedisProcess(tmp_path)
    redis.start()
    try:
        with whole_service(tmp_path, sessions=redis.url) as client:
            assert client.get("/readyz").status_code == 200
            redis.kill()
            assert client.get("/readyz").status_code == 503
            assert client.get("/healthz").status_code == 200
            redis.start()
            assert client.get("/readyz").status_code == 200
    finally:
        redis.kill()


def test_sessions_batches_and_fixes_are_counted_once_each(client: TestClient) -> None:
    before = figures(client)
    session = client.post("/v1/sessions", json={"venue": "mall", "method": "integrity_ukf"}).json()["session"]
    path = f"/v1/sessions/{session}/batches"
    for sequence in (0, 1, 1):
        assert client.post(path, json={"sequence": sequence}).status_code == 200
    assert client.post(path, json={"sequence": -1}).status_code == 422
    route = "/v1/sessions/{session}/batches"
    assert risen(before, figures(client)) == {
        'surefix_requests_total{method="POST",route="/v1/sessions",status="201"}': 1,
        f'surefix_requests_total{{method="POST",route="{route}",status="200"}}': 3,
        f'surefix_requests_total{{method="POST",route="{route}",status="422"}}': 1,
        'surefix_request_seconds_count{method="POST",route="/v1/sessions"}': 1,
        f'surefix_request_seconds_count{{method="POST",route="{route}"}}': 4,
        "surefix_batch_seconds_count": 2,
        'surefix_fixes_total{flag="initialising"}': 2,
        "surefix_sessions_opened_total": 1,
    }


def test_strangers_cannot_make_up_labels(client: TestClient) -> None:
    before = set(figures(client))
    for n in range(20):
        client.request(f"STRANGE{n}", f"/nothing/{n}")
        client.get(f"/v1/sessions/{n:032x}/fix")
        client.get(f"/v1/venues/v{n}")
    new = set(figures(client)) - before
    assert len({name for name in new if name.startswith("surefix_requests_total")}) <= 4
    assert not any("nothing" in name or "STRANGE" in name or "v1/venues/v" in name for name in new)


def test_a_defect_is_counted_as_one() -> None:
    app = create_app(Settings())

    @app.get("/defect")
    def defect() -> None:
        raise ZeroDivisionError

    service = TestClient(app, raise_server_exceptions=False)
    assert service.get("/defect").status_code == 500
    assert figures(service)['surefix_requests_total{method="GET",route="/defect",status="500"}'] == 1


def test_the_service_tells_its_own_memory_and_processor_time(client: TestClient) -> None:
    assert figures(client)["process_resident_memory_bytes"] > 1e6
