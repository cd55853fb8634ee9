"""Measurements of speed and accuracy, one command each."""
