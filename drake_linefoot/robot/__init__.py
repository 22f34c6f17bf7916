"""The robot: description, model, dynamics, leg kinematics."""
