"""Filters and statistics on arrays; knows nothing of positioning."""
