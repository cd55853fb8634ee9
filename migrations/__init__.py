"""Alembic migrations: how every database of the service is made and changed. `surefix migrate` runs them."""
