"""Contact: wrench cones, momentum observer, wrench estimate, the contact estimator."""
