"""Running: how fast, how well the command is followed, and what a run survives."""
