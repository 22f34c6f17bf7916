"""Walks over ground that the controller has a map of: stairs, gaps, stones, blocks."""
