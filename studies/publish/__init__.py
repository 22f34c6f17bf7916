"""What docs/ publishes of the studies: what made it, what is to be made again, and making it."""
