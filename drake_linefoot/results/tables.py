"""What the command line shows of a run: progress while it goes on, tables at its end."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bar
from rich.table import Table

if TYPE_CHECKING:
    from collections.abc import Callable

    from drake_linefoot.simulation.log_summary import LogSummary
    from drake_linefoot.simulation.run import Progress

NOTHING = "-"
SEGMENTS = "Velocity: forward, left [m/s], turn rate [rad/s]"


@contextmanager
def progress_bar(console: Console) -> Iterator[Callable[[Progress], None]]:
    """Show a bar inside the `with` block; yields what `simulate` calls with its progress."""
    bar = Bar(
        BarColumn(bar_width=20),
        TextColumn("{task.description}"),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )
    with bar:
        task = bar.add_task("starting", total=None)

        def show(progress: Progress) -> None:
            bar.update(
                task,
                description=progress_text(progress),
                completed=progress.time,
                total=progress.duration,
            )

        yield show


def progress_text(progress: Progress) -> str:
    """Return two lines: simulated time and its rate; commanded and measured velocity."""
    p = progress
    return (
        f"{p.time:5.2f} of {p.duration:.2f} s, {p.realtime_rate:.2f} x real time\n"
        f"commanded {_velocity(p.commanded)}, measured {_velocity(p.measured)}"
    )


def segment_table(metrics: dict[str, Any]) -> Table:
    """Return the commanded and the measured velocity of every segment."""
    title = escape(SEGMENTS)
    table = Table(title=title, title_justify="left")
    table.add_column("segment")
    for column in ("commanded", "measured", "error"):
        table.add_column(column, justify="right", no_wrap=True)
    for row in segment_rows(metrics):
        table.add_row(*map(escape, row))
    return table


def summary_table(metrics: dict[str, Any]) -> Table:
    """Return the figures of the whole run."""
    table = Table(show_header=False)
    for name, value in summary_rows(metrics).items():
        table.add_row(name, value)
    return table


def segment_rows(metrics: dict[str, Any]) -> list[tuple[str, ...]]:
    """Return name, commanded velocity, measured velocity and error of every segment."""
    columns = ("commanded", "measured", "error")
    return [
        (segment["name"], *(_velocity(segment[column]) for column in columns))
        for segment in metrics["segments"]
    ]


def summary_rows(metrics: dict[str, Any]) -> dict[str, str]:
    """Return the figures of the whole run, each with its unit, by what they say."""
    m = metrics
    failures = m["solver_failures"]
    rows = {
        "simulated": f"{m['duration_s']:.3f} s, {m['realtime_rate']:.2f} x real time",
        "steps": str(m["steps"]),
        "largest roll, pitch": f"{_degrees(m['roll_max_rad'])}, {_degrees(m['pitch_max_rad'])}",
        "largest slip of a foot": f"{1e3 * m['slip_m']:.1f} mm",
        "largest torque": f"{100.0 * m['torque_max_ratio']:.0f} % of its limit",
        "joint speed at the end": f"{m['final_joint_speed_rms']:.3f} rad/s rms",
        "MPC": _solver(m["mpc_ms"], failures["mpc"]),
        "whole-body controller": _solver(m["wbc_ms"], failures["wbc"]),
        "contact estimate": _contact(m["contact"]),
    }
    limited = {name: count for name, count in m["limited"].items() if count}
    if limited:
        rows["kept to limits"] = ", ".join(f"{n} {name}" for name, n in limited.items())
    return rows


def log_table(summary: LogSummary) -> Table:
    """Return the channels of a log."""
    title = ", ".join(f"{name} {size:.2f} MB" for name, size in summary.files.items())
    if summary.samples_per_message is not None:
        title += f"; {summary.samples_per_message} samples per message"
    table = Table(title=escape(title), title_justify="left")
    table.add_column("channel", no_wrap=True)
    table.add_column("unit")
    for column in ("shape", "samples", escape("rate [Hz]"), escape("npz [kB]"), "messages"):
        table.add_column(column, justify="right", no_wrap=True)
    for c in summary.channels:
        shape = " x ".join(map(str, c.shape)) or "1"
        samples, rate = _number(c.samples), _number(c.rate, ".0f")
        table.add_row(
            *(c.name, c.unit, shape, samples, rate, _number(c.kilobytes, ".1f")),
            _number(c.messages),
        )
    return table


def _velocity(values: Iterable[float] | None) -> str:
    if values is None:
        return NOTHING
    return " ".join(f"{round(value, 2) + 0.0:5.2f}" for value in values)  # no -0.00


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.1f} deg"


def _solver(milliseconds: dict[str, float | None], failures: int | None) -> str:
    median, p95 = (_number(milliseconds[key], ".2f") for key in ("median", "p95"))
    return f"{median} ms (median), {p95} ms (95 %), {_number(failures)} failures"


def _contact(contact: dict[str, float | None]) -> str:
    late = _number(contact["latency_ms"], ".1f")
    return (
        f"{late} ms late (median), {_number(contact['false_positives'])} false, "
        f"{_number(contact['missed'])} missed"
    )


def _number(value: float | None, spec: str = "") -> str:
    return NOTHING if value is None else format(value, spec)
