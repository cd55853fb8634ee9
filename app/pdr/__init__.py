"""Inertial samples to movement: attitude, steps, headings."""
