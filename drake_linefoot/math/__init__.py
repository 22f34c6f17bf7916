"""Ring 0: numpy only."""
