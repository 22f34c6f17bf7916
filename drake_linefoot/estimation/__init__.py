"""State estimation: an invariant Kalman filter with contacts, between sensors and controller."""
