"""What all tables share: where they are gathered, how their constraints are named, and the kinds of columns."""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, ForeignKey, Integer, MetaData

metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "fk": "fk_%(table_name)s_%(column_0_name)s_%(referred_table_name)s",
        "pk": "pk_%(table_name)s",
    }
)
KEY = BigInteger().with_variant(Integer, "sqlite")
"""SQLite counts rows by itself only in a column of exactly this type."""


def owned(column: str, by: str) -> Column[int]:
    """A column that names the row it belongs to, and goes with it."""
    return Column(column, KEY, ForeignKey(f"{by}.id", ondelete="CASCADE"), nullable=False)


def of_radio_map() -> Column[int]:
    """The first part of the key of what belongs to a radio-map version."""
    return Column("radio_map_id", KEY, ForeignKey("radio_maps.id", ondelete="CASCADE"), primary_key=True)
