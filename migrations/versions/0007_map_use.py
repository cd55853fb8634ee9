"""How scans in use fit radio maps; quality reports are made anew, with what they now hold."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision: str | None = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the table, and drop reports that lack what use is compared with: each is made again when asked for."""
    op.create_table(
        "map_use",
        sa.Column("radio_map_id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False),
        sa.Column("floor", sa.String(64), nullable=False),
        sa.Column("east", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("north", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("period", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("scans", sa.BigInteger(), nullable=False),
        sa.Column("unfit", sa.BigInteger(), nullable=False),
        sa.Column("visits", sa.BigInteger(), nullable=False),
        sa.Column("total", sa.Float(), nullable=False),
        sa.Column("total_square", sa.Float(), nullable=False),
        sa.Column("session_bits", sa.BigInteger(), nullable=False),
        sa.Column("last_ms", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("radio_map_id", "floor", "east", "north", "period", name=op.f("pk_map_use")),
        sa.ForeignKeyConstraint(
            ["radio_map_id"], ["radio_maps.id"], name=op.f("fk_map_use_radio_map_id_radio_maps"), ondelete="CASCADE"
        ),
    )
    op.execute("DELETE FROM radio_map_reports")


def downgrade() -> None:
    """Remove the table."""
    op.drop_table("map_use")
