"""Robots described from their models alone."""
