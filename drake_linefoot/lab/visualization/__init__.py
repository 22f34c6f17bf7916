"""Visualisation: Meshcat overlays, replay, plots."""
