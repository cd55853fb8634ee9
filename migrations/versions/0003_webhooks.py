"""Webhooks, and the alerts on their way to them."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision: str | None = "0002"
branch_labels = None
depends_on = None


def _key() -> sa.types.TypeEngine[int]:
    return sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    """Make the tables."""
    op.create_table(
        "webhooks",
        sa.Column("webhook", sa.String(32), nullable=False),
        sa.Column("venue_id", _key(), nullable=False),
        sa.Column("url", sa.String(2000), nullable=False),
        sa.Column("secret", sa.LargeBinary(32), nullable=False),
        sa.Column("created_ms", sa.BigInteger(), nullable=False),
        sa.Column("delivered_ms", sa.BigInteger(), nullable=True),
        sa.Column("failure", sa.String(200), nullable=True),
        sa.PrimaryKeyConstraint("webhook", name=op.f("pk_webhooks")),
        sa.ForeignKeyConstraint(
            ["venue_id"], ["venues.id"], name=op.f("fk_webhooks_venue_id_venues"), ondelete="CASCADE"
        ),
    )
    op.create_index(op.f("ix_webhooks_venue_id"), "webhooks", ["venue_id"])
    op.create_table(
        "outbox",
        sa.Column("id", _key(), nullable=False),
        sa.Column("webhook", sa.String(32), nullable=False),
        sa.Column("event", sa.String(32), nullable=False),
        sa.Column("body", sa.LargeBinary(), nullable=False),
        sa.Column("created_ms", sa.BigInteger(), nullable=False),
        sa.Column("due_ms", sa.BigInteger(), nullable=False),
        sa.Column("attempts", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_outbox")),
        sa.UniqueConstraint("webhook", "event", name=op.f("uq_outbox_webhook_event")),
        sa.ForeignKeyConstraint(
            ["webhook"], ["webhooks.webhook"], name=op.f("fk_outbox_webhook_webhooks"), ondelete="CASCADE"
        ),
    )
    op.create_index(op.f("ix_outbox_due_ms"), "outbox", ["due_ms"])


def downgrade() -> None:
    """Remove them."""
    op.drop_table("outbox")
    op.drop_table("webhooks")
