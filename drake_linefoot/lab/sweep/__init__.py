"""Batches of runs with random parameters: `linefoot sweep`."""
