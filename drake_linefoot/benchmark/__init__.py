"""Measurements of speed and memory: `linefoot bench`."""
