"""The models of the MPC, one file each, what they share, and the registry of their names."""
