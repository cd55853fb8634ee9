"""Replaying recorded walks through the methods and scoring what they answer."""
