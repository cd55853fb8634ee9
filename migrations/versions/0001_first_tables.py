"""The first tables: venues, floors, surveys, radio maps, API keys, sessions and fixes."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision: str | None = None
branch_labels = None
depends_on = None


def _key() -> sa.types.TypeEngine[int]:
    return sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def _id(table: str) -> tuple[sa.Column[int], sa.PrimaryKeyConstraint]:
    return sa.Column("id", _key(), nullable=False), sa.PrimaryKeyConstraint("id", name=op.f(f"pk_{table}"))


def _owned(table: str, column: str, by: str) -> tuple[sa.Column[int], sa.ForeignKeyConstraint]:
    name = op.f(f"fk_{table}_{column}_{by}")
    return (
        sa.Column(column, _key(), nullable=False),
        sa.ForeignKeyConstraint([column], [f"{by}.id"], name=name, ondelete="CASCADE"),
    )


def upgrade() -> None:
    """Make every table."""
    op.create_table(
        "venues",
        *_id("venues"),
        sa.Column("venue", sa.String(64), nullable=False),
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("revision", sa.BigInteger(), nullable=False),
        sa.Column("active_version", sa.Integer(), nullable=True),
        sa.Column("created_ms", sa.BigInteger(), nullable=False),
        sa.UniqueConstraint("venue", name=op.f("uq_venues_venue")),
    )
    op.create_table(
        "floors",
        *_id("floors"),
        *_owned("floors", "venue_id", "venues"),
        sa.Column("floor", sa.String(64), nullable=False),
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("level", sa.Integer(), nullable=False),
        sa.Column("width_m", sa.Float(), nullable=False),
        sa.Column("height_m", sa.Float(), nullable=False),
        sa.Column("latitude_deg", sa.Float(), nullable=True),
        sa.Column("longitude_deg", sa.Float(), nullable=True),
        sa.Column("rotation_rad", sa.Float(), nullable=True),
        sa.Column("plan", sa.LargeBinary(), nullable=True),
        sa.Column("image", sa.LargeBinary(), nullable=True),
        sa.UniqueConstraint("venue_id", "floor", name=op.f("uq_floors_venue_id_floor")),
    )
    op.create_table(
        "surveys",
        *_id("surveys"),
        *_owned("surveys", "venue_id", "venues"),
        sa.Column("format", sa.String(16), nullable=False),
        sa.Column("device", sa.JSON(), nullable=True),
        sa.Column("accepted", sa.Integer(), nullable=False),
        sa.Column("rejected", sa.Integer(), nullable=False),
        sa.Column("created_ms", sa.BigInteger(), nullable=False),
    )
    op.create_table(
        "fingerprints",
        *_id("fingerprints"),
        *_owned("fingerprints", "survey_id", "surveys"),
        *_owned("fingerprints", "floor_id", "floors"),
        sa.Column("walk", sa.String(200), nullable=False),
        sa.Column("time_s", sa.Float(), nullable=False),
        sa.Column("x_m", sa.Float(), nullable=False),
        sa.Column("y_m", sa.Float(), nullable=False),
        sa.Column("readings", sa.LargeBinary(), nullable=False),
    )
    op.create_table(
        "radio_maps",
        *_id("radio_maps"),
        *_owned("radio_maps", "venue_id", "venues"),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("surveys", sa.JSON(), nullable=False),
        sa.Column("summary", sa.JSON(), nullable=False),
        sa.Column("body", sa.LargeBinary(), nullable=False),
        sa.Column("created_ms", sa.BigInteger(), nullable=False),
        sa.UniqueConstraint("venue_id", "version", name=op.f("uq_radio_maps_venue_id_version")),
    )
    op.create_table(
        "api_keys",
        *_id("api_keys"),
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("digest", sa.LargeBinary(32), nullable=False),
        sa.Column("scopes", sa.JSON(), nullable=False),
        sa.Column("created_ms", sa.BigInteger(), nullable=False),
        sa.Column("revoked_ms", sa.BigInteger(), nullable=True),
        sa.UniqueConstraint("digest", name=op.f("uq_api_keys_digest")),
    )
    op.create_table(
        "sessions",
        sa.Column("session", sa.String(32), nullable=False),
        *_owned("sessions", "venue_id", "venues"),
        sa.Column("method", sa.String(64), nullable=False),
        sa.Column("alert_limit_m", sa.Float(), nullable=False),
        sa.Column("risk", sa.Float(), nullable=False),
        sa.Column("floor_hint", sa.String(64), nullable=True),
        sa.Column("start", sa.JSON(), nullable=True),
        sa.Column("device", sa.JSON(), nullable=True),
        sa.Column("created_ms", sa.BigInteger(), nullable=False),
        sa.Column("expires_ms", sa.BigInteger(), nullable=False),
        sa.Column("sequence", sa.Integer(), nullable=False),
        sa.Column("state", sa.LargeBinary(), nullable=False),
        sa.Column("ticket_key", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("session", name=op.f("pk_sessions")),
    )
    op.create_table(
        "fixes",
        sa.Column("session", sa.String(32), nullable=False),
        sa.Column("sequence", sa.Integer(), nullable=False),
        sa.Column("t_ms", sa.BigInteger(), nullable=True),
        sa.Column("body", sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(
            ["session"], ["sessions.session"], name=op.f("fk_fixes_session_sessions"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("session", "sequence", name=op.f("pk_fixes")),
    )
    op.create_index(op.f("ix_surveys_venue_id"), "surveys", ["venue_id"])
    op.create_index(op.f("ix_fingerprints_survey_id"), "fingerprints", ["survey_id"])
    op.create_index(op.f("ix_sessions_venue_id"), "sessions", ["venue_id"])
    op.create_index(op.f("ix_sessions_expires_ms"), "sessions", ["expires_ms"])


def downgrade() -> None:
    """Remove every table, and what is in it."""
    for table in ("fixes", "sessions", "api_keys", "radio_maps", "fingerprints", "surveys", "floors", "venues"):
        op.drop_table(table)
