"""Many phones at once: real sessions and batches against a running service, and how long each answer took."""

from __future__ import annotations

import asyncio
import time
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import httpx
import numpy as np

from app.simulation.load_walks import with_sequence

PATIENCE_S = 30.0
LONGEST_DETAIL = 200
JSON = {"Content-Type": "application/json"}
PERCENTILES = (50, 90, 99, 100)


@dataclass
class Outcome:
    """What a load test saw. latency_s : of every answered batch.  late : batches that could not be sent when due."""

    latency_s: list[float] = field(default_factory=list)
    errors: Counter[str] = field(default_factory=Counter)
    positioned: int = 0
    late: int = 0
    wall_s: float = 0.0

    def summary(self) -> dict[str, Any]:
        """Throughput, latency percentiles in ms and errors, ready for JSON; latencies are null if nothing answered."""
        batches = len(self.latency_s)
        latency_ms = 1000 * np.percentile(self.latency_s, PERCENTILES) if batches else [None] * len(PERCENTILES)
        return {
            "batches": batches,
            "seconds": round(self.wall_s, 3),
            "batches_per_second": round(batches / self.wall_s, 2) if self.wall_s else 0.0,
            "latency_ms": {
                "max" if rank == 100 else f"p{rank}": None if value is None else round(float(value), 2)
                for rank, value in zip(PERCENTILES, latency_ms, strict=True)
            },
            "positioned": self.positioned,
            "late": self.late,
            "errors": dict(self.errors),
        }


class LoadPhones:
    """Phones that walk in a venue until a time is over.

    Parameters
    ----------
    opening : body of POST /v1/sessions.  walks : batches without sequence; phones take them in turn, and again.
    rate_hz : batches a second and phone; 0: each as soon as the one before is answered.
    """

    def __init__(
        self, client: httpx.AsyncClient, opening: dict[str, Any], walks: list[list[bytes]], rate_hz: float
    ) -> None:
        self._client, self._opening, self._walks, self._rate_hz = client, opening, walks, rate_hz
        self._named: dict[str, str] = {}
        self.outcome = Outcome()

    async def run(self, phones: int, seconds: float, seed: int) -> Outcome:
        """Walk with that many phones; their first batches are spread over one period."""
        period_s = 1.0 / self._rate_hz if self._rate_hz else 0.0
        delays_s = np.random.default_rng(seed).uniform(0.0, period_s, phones) if period_s else np.zeros(phones)
        began = time.perf_counter()
        until = began + seconds
        await asyncio.gather(*(self._phone(n, began + delay, until) for n, delay in enumerate(delays_s.tolist())))
        self.outcome.wall_s = time.perf_counter() - began
        return self.outcome

    async def _phone(self, number: int, due: float, until: float) -> None:
        visit = 0
        while due < until and time.perf_counter() < until:
            session = await self._open()
            if session is None:
                await asyncio.sleep(1.0)
                continue
            due = await self._walk(session, self._walks[(number + visit) % len(self._walks)], due, until)
            await self._request("DELETE", "/v1/sessions/{session}", 204, session)
            visit += 1

    async def _walk(self, session: str, walk: list[bytes], due: float, until: float) -> float:
        """Send a walk's batches when due; gives when the next would be."""
        period_s = 1.0 / self._rate_hz if self._rate_hz else 0.0
        for sequence, rest in enumerate(walk):
            now = time.perf_counter()
            if max(now, due) >= until:
                break
            if now < due:
                await asyncio.sleep(due - now)
            elif period_s and now - due > period_s:
                self.outcome.late += 1
                due = now
            began = time.perf_counter()
            body = with_sequence(sequence, rest)
            answer = await self._request("POST", "/v1/sessions/{session}/batches", 200, session, body)
            if answer is not None:
                self.outcome.latency_s.append(time.perf_counter() - began)
                self.outcome.positioned += answer.json()["position"] is not None
            due += period_s
        return due

    async def _open(self) -> str | None:
        answer = await self._request("POST", "/v1/sessions", 201, json=self._opening)
        return None if answer is None else str(answer.json()["session"])

    async def _request(
        self, verb: str, route: str, status: int, session: str = "", content: bytes | None = None, json: Any = None
    ) -> httpx.Response | None:
        """The answer, or None if it is not the expected one, which is counted."""
        headers = JSON if content is not None else None
        path = route.replace("{session}", session)
        try:
            answer = await self._client.request(verb, path, content=content, json=json, headers=headers)
        except httpx.HTTPError as error:
            address = self._client.base_url.copy_with(userinfo=b"")
            self._count(f"{verb} {str(address).rstrip('/')}{route}: {type(error).__name__}", str(error))
            return None
        if answer.status_code != status:
            self._count(f"{verb} {route}: {answer.status_code}", _detail(answer))
            return None
        return answer

    def _count(self, failure: str, why: str) -> None:
        """Count a failure under what was told of its first occurrence; the rest may name a session or a sequence."""
        name = self._named.setdefault(failure, f"{failure} {why[:LONGEST_DETAIL]}".strip())
        self.outcome.errors[name] += 1


def _detail(answer: httpx.Response) -> str:
    """What a problem document says; nothing of another answer."""
    try:
        return str(answer.json()["detail"])
    except (ValueError, KeyError, TypeError):
        return ""


async def load(
    url: str,
    key: str | None,
    opening: dict[str, Any],
    walks: list[list[bytes]],
    phones: int,
    seconds: float,
    rate_hz: float,
    seed: int,
) -> Outcome:
    """Run a load test against the service at url. LoadPhones describes the rest."""
    headers = {"Authorization": f"Bearer {key}"} if key else {}
    limits = httpx.Limits(max_connections=phones, max_keepalive_connections=phones)
    async with httpx.AsyncClient(
        base_url=url, headers=headers, limits=limits, timeout=PATIENCE_S, trust_env=False
    ) as client:
        return await LoadPhones(client, opening, walks, rate_hz).run(phones, seconds, seed)
