"""What the walk survives, held against its thresholds: `python -m studies.robustness`."""
