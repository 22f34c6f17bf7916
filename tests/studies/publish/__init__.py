"""What docs/ publishes, and how it stands."""
