"""Gait: state machine, pendulum, footholds, swing foot, schedule."""
