"""The contact estimator studied: `python -m studies.contact`."""
