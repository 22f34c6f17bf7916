"""Model-predictive control: Enhanced Centroidal Dynamics and its quadratic program."""
