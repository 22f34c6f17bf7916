"""The closed loop and its drawings."""
