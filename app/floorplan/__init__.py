"""Georeference and plan of a floor."""
