"""Tests of drake_linefoot.lab.gym."""
