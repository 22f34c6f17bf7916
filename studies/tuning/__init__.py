"""Weights of the MPC, searched: `python -m studies.tuning`."""
