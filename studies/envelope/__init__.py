"""The fastest commands that are walked: `python -m studies.envelope`."""
