"""The MPC's programs as a problem set for qpbenchmark: `python -m studies.qpbenchmark`."""
