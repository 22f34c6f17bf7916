"""Measurements of speed and memory: `python -m studies.bench`."""
