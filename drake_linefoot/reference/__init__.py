"""Reference: the gait's horizon turned into the desired trajectory x_H* of (40)."""
