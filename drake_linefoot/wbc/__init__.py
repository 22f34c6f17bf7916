"""Whole-body control: tasks, priorities, wrench program."""
