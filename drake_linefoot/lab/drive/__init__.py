"""Driving: a live simulation in Meshcat under the hands of a user."""
