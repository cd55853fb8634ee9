"""Surefix: indoor positioning as a web service that says when not to trust it."""
