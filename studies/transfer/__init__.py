"""The same walks in two simulators, of the MIT Humanoid and of others."""
