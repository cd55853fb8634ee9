"""Access points that a radio map can no longer rely on, and the sessions that said so."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision: str | None = "0003"
branch_labels = None
depends_on = None


def _of_a_radio_map(table: str) -> tuple[sa.Column[int], sa.ForeignKeyConstraint]:
    return (
        sa.Column("radio_map_id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False),
        sa.ForeignKeyConstraint(
            ["radio_map_id"],
            ["radio_maps.id"],
            name=op.f(f"fk_{table}_radio_map_id_radio_maps"),
            ondelete="CASCADE",
        ),
    )


def upgrade() -> None:
    """Make the tables."""
    op.create_table(
        "watched_access_points",
        *_of_a_radio_map("watched_access_points"),
        sa.Column("bssid", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("reason", sa.String(200), nullable=False),
        sa.Column("first_seen_ms", sa.BigInteger(), nullable=False),
        sa.Column("last_seen_ms", sa.BigInteger(), nullable=False),
        sa.Column("evidence", sa.Integer(), nullable=False),
        sa.Column("removed_ms", sa.BigInteger(), nullable=True),
        sa.PrimaryKeyConstraint("radio_map_id", "bssid", name=op.f("pk_watched_access_points")),
    )
    op.create_table(
        "watch_evidence",
        *_of_a_radio_map("watch_evidence"),
        sa.Column("bssid", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("session_digest", sa.LargeBinary(32), nullable=False),
        sa.Column("seen_ms", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("radio_map_id", "bssid", "session_digest", name=op.f("pk_watch_evidence")),
    )
    op.create_index(op.f("ix_watch_evidence_seen_ms"), "watch_evidence", ["seen_ms"])


def downgrade() -> None:
    """Remove them."""
    op.drop_table("watch_evidence")
    op.drop_table("watched_access_points")
