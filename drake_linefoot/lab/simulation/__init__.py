"""Simulation: scene, command, recording, metrics, output."""
