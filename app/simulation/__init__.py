"""Seeded buildings, walkers and phones for the demo, tests and load."""
