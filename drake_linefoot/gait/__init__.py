"""Gait: pendulum, footholds, swing foot, schedule, reference of the MPC."""
