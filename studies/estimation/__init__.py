"""The state estimator studied: `python -m studies.estimation`."""
