"""What each Fix was made of, for smoothing its track afterwards; of earlier ones it is not known."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision: str | None = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column."""
    op.add_column("fixes", sa.Column("evidence", sa.LargeBinary()))


def downgrade() -> None:
    """Remove it."""
    op.drop_column("fixes", "evidence")
