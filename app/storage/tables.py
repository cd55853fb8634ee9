"""The tables, as the migrations leave them (tests/storage compares the two).

Times are Unix milliseconds of the server's clock unless a name says otherwise; a `_ms` of a fix is the phone's.
"""

from __future__ import annotations

from sqlalchemy import (
    JSON,
    BigInteger,
    Column,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    String,
    Table,
    UniqueConstraint,
)

from app.storage.schema import KEY, of_radio_map, owned
from app.storage.schema import metadata as metadata

venues = Table(
    "venues",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("venue", String(64), nullable=False, unique=True),
    Column("name", String(200), nullable=False),
    # rises with everything that changes the venue's Site: what caches compare
    Column("revision", BigInteger, nullable=False, default=1),
    # number of the active radio-map version; null until one is published
    Column("active_version", Integer),
    Column("created_ms", BigInteger, nullable=False, default=0),
)

floors = Table(
    "floors",
    metadata,
    Column("id", KEY, primary_key=True),
    owned("venue_id", "venues"),
    Column("floor", String(64), nullable=False),
    Column("name", String(200), nullable=False),
    Column("level", Integer, nullable=False),
    Column("width_m", Float, nullable=False),
    Column("height_m", Float, nullable=False),
    Column("latitude_deg", Float),
    Column("longitude_deg", Float),
    Column("rotation_rad", Float),
    # GeoJSON as it was sent, repaired; the image is a PNG
    Column("plan", LargeBinary),
    Column("image", LargeBinary),
    UniqueConstraint("venue_id", "floor"),
)

surveys = Table(
    "surveys",
    metadata,
    Column("id", KEY, primary_key=True),
    owned("venue_id", "venues"),
    # json, csv, traces or geosubmit
    Column("format", String(16), nullable=False),
    Column("device", JSON),
    Column("accepted", Integer, nullable=False),
    Column("rejected", Integer, nullable=False),
    Column("created_ms", BigInteger, nullable=False),
    Index(None, "venue_id"),
)

fingerprints = Table(
    "fingerprints",
    metadata,
    Column("id", KEY, primary_key=True),
    owned("survey_id", "surveys"),
    owned("floor_id", "floors"),
    Column("walk", String(200), nullable=False),
    Column("time_s", Float, nullable=False),
    Column("x_m", Float, nullable=False),
    Column("y_m", Float, nullable=False),
    # app/wifi/fingerprint_codec.py
    Column("readings", LargeBinary, nullable=False),
    Index(None, "survey_id"),
)

radio_maps = Table(
    "radio_maps",
    metadata,
    Column("id", KEY, primary_key=True),
    owned("venue_id", "venues"),
    Column("version", Integer, nullable=False),
    Column("surveys", JSON, nullable=False),
    # counts for listings
    Column("summary", JSON, nullable=False),
    # app/wifi/radio_map_codec.py
    Column("body", LargeBinary, nullable=False),
    Column("created_ms", BigInteger, nullable=False),
    UniqueConstraint("venue_id", "version"),
)

api_keys = Table(
    "api_keys",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("name", String(200), nullable=False),
    # SHA-256 of a random key of 256 bits: nothing to guess, so nothing to slow down
    Column("digest", LargeBinary(32), nullable=False, unique=True),
    Column("scopes", JSON, nullable=False),
    Column("created_ms", BigInteger, nullable=False),
    Column("revoked_ms", BigInteger),
)

sessions = Table(
    "sessions",
    metadata,
    Column("session", String(32), primary_key=True),
    owned("venue_id", "venues"),
    Column("method", String(64), nullable=False),
    Column("alert_limit_m", Float, nullable=False),
    Column("risk", Float, nullable=False),
    Column("floor_hint", String(64)),
    Column("start", JSON),
    Column("device", JSON),
    Column("created_ms", BigInteger, nullable=False),
    Column("expires_ms", BigInteger, nullable=False),
    # of the newest batch, -1 before there is one; the state is the one after it
    Column("sequence", Integer, nullable=False),
    Column("state", LargeBinary, nullable=False),
    Column("ticket_key", LargeBinary, nullable=False),
    Index(None, "venue_id"),
    Index(None, "expires_ms"),
)

fixes = Table(
    "fixes",
    metadata,
    Column("session", String(32), ForeignKey("sessions.session", ondelete="CASCADE"), primary_key=True),
    Column("sequence", Integer, primary_key=True),
    # the phone's time that the fix accounts for
    Column("t_ms", BigInteger),
    # the answer, byte for byte
    Column("body", LargeBinary, nullable=False),
    # app/fusion/evidence_codec.py; null before there was any such thing
    Column("evidence", LargeBinary),
)

tasks = Table(
    "tasks",
    metadata,
    Column("task", String(32), primary_key=True),
    # running, done or failed
    Column("status", String(16), nullable=False),
    Column("created_ms", BigInteger, nullable=False),
    # when the worker that runs it last said so
    Column("alive_ms", BigInteger, nullable=False),
    # the receipt or the problem, as JSON, byte for byte
    Column("outcome", LargeBinary),
    Index(None, "created_ms"),
)

webhooks = Table(
    "webhooks",
    metadata,
    Column("webhook", String(32), primary_key=True),
    owned("venue_id", "venues"),
    Column("url", String(2000), nullable=False),
    # signs what is sent, so it is stored as it is
    Column("secret", LargeBinary(32), nullable=False),
    Column("created_ms", BigInteger, nullable=False),
    # of the newest delivery, and why the newest attempt failed (null after a delivery)
    Column("delivered_ms", BigInteger),
    Column("failure", String(200)),
    Index(None, "venue_id"),
)

# alerts on their way to webhooks: written in the transaction of the Fix, removed once delivered
outbox = Table(
    "outbox",
    metadata,
    Column("id", KEY, primary_key=True),
    Column("webhook", String(32), ForeignKey("webhooks.webhook", ondelete="CASCADE"), nullable=False),
    Column("event", String(32), nullable=False),
    Column("body", LargeBinary, nullable=False),
    Column("created_ms", BigInteger, nullable=False),
    # when it may be tried; a worker that takes it moves this ahead, so that no other does
    Column("due_ms", BigInteger, nullable=False),
    Column("attempts", Integer, nullable=False),
    UniqueConstraint("webhook", "event"),
    Index(None, "due_ms"),
)

watched_access_points = Table(
    "watched_access_points",
    metadata,
    of_radio_map(),
    Column("bssid", BigInteger, primary_key=True, autoincrement=False),
    Column("reason", String(200), nullable=False),
    Column("first_seen_ms", BigInteger, nullable=False),
    Column("last_seen_ms", BigInteger, nullable=False),
    # sessions that have excluded it
    Column("evidence", Integer, nullable=False),
    # by an administrator; null while it is watched
    Column("removed_ms", BigInteger),
)

# which sessions have excluded which access point, until there are enough of them
watch_evidence = Table(
    "watch_evidence",
    metadata,
    of_radio_map(),
    Column("bssid", BigInteger, primary_key=True, autoincrement=False),
    # SHA-256 of the session, which this may outlive
    Column("session_digest", LargeBinary(32), primary_key=True),
    Column("seen_ms", BigInteger, nullable=False),
    Index(None, "seen_ms"),
)

# how many sessions have heard which access point as it was surveyed, by hours since 1970
watch_confirmations = Table(
    "watch_confirmations",
    metadata,
    of_radio_map(),
    Column("bssid", BigInteger, primary_key=True, autoincrement=False),
    Column("hour", Integer, primary_key=True, autoincrement=False),
    Column("sessions", Integer, nullable=False),
)

radio_map_reports = Table(
    "radio_map_reports",
    metadata,
    of_radio_map(),
    # JSON; the picture is a PNG
    Column("report", LargeBinary, nullable=False),
    Column("picture", LargeBinary, nullable=False),
    Column("created_ms", BigInteger, nullable=False),
)

map_use = Table(
    "map_use",
    metadata,
    of_radio_map(),
    Column("floor", String(64), primary_key=True),
    *(Column(n, Integer, primary_key=True, autoincrement=False) for n in ("east", "north", "period")),
    *(Column(n, BigInteger, nullable=False) for n in ("scans", "unfit", "visits", "session_bits", "last_ms")),
    *(Column(n, Float, nullable=False) for n in ("total", "total_square")),
)
