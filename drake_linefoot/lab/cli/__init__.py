"""The command `linefoot`: its options, its commands, how each ends."""

from drake_linefoot.lab.cli.command_line import app, main

__all__ = ["app", "main"]
