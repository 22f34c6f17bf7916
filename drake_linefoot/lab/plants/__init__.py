"""What simulates the robot: ports that the closed loop is wired to."""
