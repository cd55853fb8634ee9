"""Quality reports of radio-map versions."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision: str | None = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        "radio_map_reports",
        sa.Column("radio_map_id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False),
        sa.Column("report", sa.LargeBinary(), nullable=False),
        sa.Column("picture", sa.LargeBinary(), nullable=False),
        sa.Column("created_ms", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("radio_map_id", name=op.f("pk_radio_map_reports")),
        sa.ForeignKeyConstraint(
            ["radio_map_id"],
            ["radio_maps.id"],
            name=op.f("fk_radio_map_reports_radio_map_id_radio_maps"),
            ondelete="CASCADE",
        ),
    )


def downgrade() -> None:
    """Remove it."""
    op.drop_table("radio_map_reports")
