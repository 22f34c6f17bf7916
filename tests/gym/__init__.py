"""Tests of drake_linefoot.gym."""
