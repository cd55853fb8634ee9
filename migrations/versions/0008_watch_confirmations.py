"""Sessions that have heard an access point as it was surveyed, beside those that exclude it."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision: str | None = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        "watch_confirmations",
        sa.Column("radio_map_id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False),
        sa.Column("bssid", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("hour", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("sessions", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("radio_map_id", "bssid", "hour", name=op.f("pk_watch_confirmations")),
        sa.ForeignKeyConstraint(
            ["radio_map_id"],
            ["radio_maps.id"],
            name=op.f("fk_watch_confirmations_radio_map_id_radio_maps"),
            ondelete="CASCADE",
        ),
    )


def downgrade() -> None:
    """Remove the table."""
    op.drop_table("watch_confirmations")
