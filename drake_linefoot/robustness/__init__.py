"""What the walk survives: sweeps held against their bars, and the contact estimator studied."""
