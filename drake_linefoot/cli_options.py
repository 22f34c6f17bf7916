"""The options of the command `linefoot`: how a word becomes a value, or is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.mpc.parameters import MODELS

LARGEST_SEED = 2**63 - 1
LARGEST_PORT = 65535


def _number(text: str) -> float:
    """Return the finite number that a word of the command line is."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise typer.BadParameter(f"{text!r} must be a finite number")
    return value


def _length(text: str) -> float:
    """Return the length of a run [s]."""
    value = _number(text)
    if value <= 0.0:
        raise typer.BadParameter(f"{text!r} must be a number above 0, in s")
    return value


def _rate(text: str) -> float:
    """Return how fast a replay goes [-]."""
    value = _number(text)
    if value < 0.0:
        raise typer.BadParameter(f"{text!r} must not be negative")
    return value


def _seed(text: str) -> int:
    """Return a seed."""
    if not (text.isdecimal() and len(text) < 20 and int(text) <= LARGEST_SEED):
        raise typer.BadParameter(f"{text!r} must be a whole number from 0 to {LARGEST_SEED}")
    return int(text)


def _port(text: str) -> int:
    """Return the number of a port."""
    if not (text.isdecimal() and len(text) < 6 and 0 < int(text) <= LARGEST_PORT):
        raise typer.BadParameter(f"{text!r} must be a whole number from 1 to {LARGEST_PORT}")
    return int(text)


def _processes(text: str) -> int:
    """Return a number of processes."""
    if not (text.isdecimal() and len(text) < 5 and int(text) > 0):
        raise typer.BadParameter(f"{text!r} must be a whole number above 0")
    return int(text)


def _count(value: str | int) -> int:
    """Return a number of things of which there may be none; `value` may be the default."""
    text = str(value)
    if not (text.isdecimal() and len(text) < 7):
        raise typer.BadParameter(f"{text!r} must be a whole number, not negative")
    return int(text)


def _model(text: str) -> str:
    """Return the name of a model of the MPC."""
    if text not in MODELS:
        raise typer.BadParameter(f"{text!r} must be one of {list(MODELS)}")
    return text


ScenarioName = Annotated[
    str, typer.Argument(metavar="SCENARIO", help="Name of a shipped one, or a YAML file.")
]
Duration = Annotated[
    float | None,
    typer.Option(
        parser=_length,
        metavar="SECONDS",
        help="Length of the run: stops earlier, or holds the last segment for longer.",
    ),
]
Forward = Annotated[
    float | None,
    typer.Option(parser=_number, metavar="M/S", help="Stand 1 s, then walk: forward velocity."),
]
Left = Annotated[
    float | None,
    typer.Option(parser=_number, metavar="M/S", help="Stand 1 s, then walk: velocity to the left."),
]
Turn = Annotated[
    float | None,
    typer.Option(parser=_number, metavar="RAD/S", help="Stand 1 s, then walk: turn to the left."),
]
Seed = Annotated[
    int | None, typer.Option(parser=_seed, metavar="NUMBER", help="Of everything random.")
]
Model = Annotated[
    str | None,
    typer.Option(parser=_model, metavar="NAME", help=f"Model of the MPC: {' or '.join(MODELS)}."),
]
Rate = Annotated[
    float,
    typer.Option(parser=_rate, metavar="NUMBER", help="1 is real time, 0 as fast as possible."),
]
Length = Annotated[
    float | None,
    typer.Option(parser=_length, metavar="SECONDS", help="End by itself after this wall time."),
]
Port = Annotated[
    int | None,
    typer.Option(parser=_port, metavar="NUMBER", help="Of the page; else the first free one."),
]
Processes = Annotated[
    int | None,
    typer.Option(parser=_processes, metavar="NUMBER", help="Processes; else one per processor."),
]
Count = Annotated[
    int,
    typer.Option(
        parser=_count, metavar="NUMBER", help="Of the worst runs of each group; 0 for none."
    ),
]
Runs = Annotated[
    int | None,
    typer.Option(parser=_processes, metavar="NUMBER", help="Of each group; else as the file says."),
]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="Use the cluster of this dask scheduler, tcp://..."),
]
Sweeps = Annotated[
    list[Path] | None,
    typer.Argument(metavar="FILE...", help="Sweeps; else examples/sweeps, nominal and robustness."),
]
