"""What the command line shows of a run: progress while it goes on, tables at its end."""

import math
import time as clock
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console, JustifyMethod, OverflowMethod
from rich.markup import escape
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bar
from rich.table import Table

from drake_linefoot.errors import InputError, legible
from drake_linefoot.lab.simulation.log import read_log
from drake_linefoot.lab.simulation.mcap_log import MCAP, METADATA, STEP
from drake_linefoot.lab.simulation.recording import CHANNELS, DERIVED, LOG, Run, log_of
from drake_linefoot.lab.simulation.run import Progress
from drake_linefoot.lab.simulation.run_view import flattened

NOTHING = "-"
VERDICTS = {True: "yes", False: "**NO**", None: "undecided"}  # whether a bar is met
PATIENCE = 60.0  # [s] of wall time
WIDTH = 110  # [letters] of a table that is not printed to a terminal
MOST_SEGMENTS, MOST_ASTRAY = 100, 10  # that are listed
SEGMENTS = "Velocity: forward, left [m/s], turn rate [rad/s]"
GAIT = "Gait: medians of flights and strides; cost of transport by positive, by all work"
GAIT_HEAD = ("segment", "flight [ms]", "duty factor", "Froude", "positive", "all work", "at limit")


def wide_console() -> Console:
    """Return a console whose tables are not cut where there is no terminal."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = WIDTH
    return console


@contextmanager
def progress_bar(console: Console) -> Iterator[Callable[[Progress], None]]:
    """Show a bar inside the `with` block; yields what `simulate` calls with its progress.

    Where there is no terminal, a walk that lasts says once in `PATIENCE` how far and fast it is.
    """
    said = clock.monotonic()
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
            nonlocal said
            text, total = progress_text(progress), progress.duration
            bar.update(task, description=text, completed=progress.time, total=total)
            if not console.is_terminal and clock.monotonic() - said > PATIENCE:
                said = clock.monotonic()
                console.print(text.splitlines()[0], markup=False)

        yield show


def progress_text(progress: Progress) -> str:
    """Return two lines: simulated time and its rate; commanded and measured velocity."""
    p = progress
    said = ", ".join(["", *p.warnings])
    return (
        f"{p.time:5.2f} of {p.duration:.2f} s, {p.realtime_rate:.2f} x real time{said}\n"
        f"commanded {_velocity(p.commanded)}, measured {_velocity(p.measured)}"
    )


def segment_table(metrics: dict[str, Any]) -> Table:
    """Return the commanded and the measured velocity of every segment."""
    head = ("segment", "commanded", "measured", "error")
    return number_table(head, segment_rows(metrics), SEGMENTS, wrapped="segment")


def gait_table(metrics: dict[str, Any]) -> Table:
    """Return the figures of the gait of every segment that has some."""
    return number_table(GAIT_HEAD, gait_rows(metrics), GAIT, wrapped="segment")


def summary_table(metrics: dict[str, Any]) -> Table:
    """Return the figures of the whole run."""
    table = Table(show_header=False)
    for name, values in summary_rows(metrics).items():
        table.add_row(legible(name), legible(", ".join(values), 400))
    return table


def segment_rows(metrics: dict[str, Any]) -> list[tuple[str, ...]]:
    """Return name, commanded velocity, measured velocity and error of each segment.

    Of many it is the first ones; the last row says where the others are.
    """
    columns, segments = ("commanded", "measured", "error"), metrics["segments"]
    rows = [
        (segment["name"], *(_velocity(segment[column]) for column in columns))
        for segment in segments[:MOST_SEGMENTS]
    ]
    if left := len(segments) - len(rows):
        rows.append((f"{left} more in metrics.json", *[NOTHING] * len(columns)))
    return rows


def gait_rows(metrics: dict[str, Any]) -> list[tuple[str, ...]]:
    """Return name and figures of the gait of every segment that has some, see `gait_figures`."""
    return [
        (
            segment["name"],
            number(None if g["flight_s"] is None else 1e3 * g["flight_s"], ".0f"),
            number(g["duty_factor"], ".2f"),
            number(g["froude_number"], ".2f"),
            number(g["cost_of_transport"], ".2f"),
            number(g["cost_of_transport_absolute"], ".2f"),
            number(g["torque_at_limit"], ".0%"),
        )
        for segment in metrics["segments"]
        if (g := segment["gait"]) is not None
    ]


def summary_rows(metrics: dict[str, Any]) -> dict[str, tuple[str, ...]]:
    """Return the figures of the whole run by what they say: a number with its unit, or several."""
    m = metrics
    failures = m["solver_failures"]
    rows: dict[str, tuple[str, ...]] = {
        "simulated": (f"{m['duration_s']:.3f} s", f"{m['realtime_rate']:.2f} x real time"),
        "steps": (str(m["steps"]),),
        "largest roll, pitch": (_degrees(m["roll_max_rad"]), _degrees(m["pitch_max_rad"])),
        "largest slip of a foot": (f"{_scaled(m['slip_m'], 1e3)} mm",),
        "centre of pressure at the edge": _edges(m["cop_at_edge"]),
        "largest torque": (f"{_scaled(m['torque_max_ratio'], 100.0, '.0f')} % of its limit",),
        "a torque at its limit": (f"{_scaled(m['torque_at_limit'], 100.0, '.1f')} % of the time",),
        "joint speed at the end": (f"{number(m['final_joint_speed_rms'], '.3f')} rad/s rms",),
        "MPC": _solver(m["mpc_ms"], failures["mpc"]),
        "whole-body controller": _solver(m["wbc_ms"], failures["wbc"]),
        "contact estimate": _contact(m["contact"]),
    }
    slowed = [_slowed(part) for part in m["slowed"]]
    if slowed:
        rows["command limited"] = ("; ".join(slowed),)
    limited = {name: count for name, count in m["limited"].items() if count}
    if limited:
        rows |= {f"{name} limited": (str(count),) for name, count in limited.items()}
    if stopped := m["joints_at_stops"]:
        shares = (f"{name} {share:.0%}" for name, share in stopped.items())
        rows["at joint limit, share of time"] = tuple(shares)
    if astray := [s["name"] for s in m["segments"] if s["off_course"]]:
        more = f", and {len(astray) - MOST_ASTRAY} more" if len(astray) > MOST_ASTRAY else ""
        rows["not as commanded"] = (", ".join(astray[:MOST_ASTRAY]) + more,)
    return rows


def log_table(folder: str | Path) -> Table:
    """Return the channels of the logs of a run; a channel derived from others is in the MCAP alone.

    Raises:
        InputError: there is no log, or it cannot be read.
    """
    folder = Path(folder)
    file, run = log_of(folder), Run.load(folder)
    title = f"{LOG} {file.stat().st_size / 1e6:.2f} MB"
    if read_log(file).ended is None:
        title = f"{file}: a run that has not ended, up to {float(run.time[-1:].sum()):.3f} s"
    messages: dict[str, int] = {}
    if (folder / MCAP).exists():
        messages, step = _read_mcap(folder / MCAP)
        megabytes = (folder / MCAP).stat().st_size / 1e6
        title += f", {MCAP} {megabytes:.2f} MB; {step} samples per message"
    rows = []
    for name, channel in (CHANNELS | DERIVED).items():
        values = getattr(run, name)
        counted, size = None, None
        if name in CHANNELS:
            counted, size = len(values), values.nbytes / 1e3
        shape = " x ".join(map(str, values.shape[1:])) or "1"
        figures = number(counted), number(_rate(run, name), ".0f"), number(size, ".1f")
        rows.append((name, channel.unit, shape, *figures, number(messages.get(f"/{name}"))))
    head = ("channel", "unit", "shape", "samples", "rate [Hz]", "log [kB]", "messages")
    return number_table(head, rows, title, words=2, wrapped="unit")


def number_table(
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    title: str | None = None,
    words: int = 1,
    wrapped: str | None = None,
) -> Table:
    """Return a table for the terminal.

    Args:
        head: names of the columns.
        rows: a cell for each column.
        title: above the table.
        words: number of columns, from the left, that hold words; the others hold numbers.
        wrapped: name of the column that may be broken where the terminal is narrow.
    """
    table = Table(title=title and escape(legible(title, 400)), title_justify="left")
    for i, name in enumerate(head):
        justify: JustifyMethod = "left" if i < words else "right"
        overflow: OverflowMethod = "fold" if name == wrapped else "ellipsis"
        table.add_column(escape(name), justify=justify, overflow=overflow, no_wrap=name != wrapped)
    for row in rows:
        table.add_row(*(escape(legible(cell)) for cell in row))
    return table


def number(value: float | None, spec: str = "") -> str:
    """Return a number in a format of Python's, or what stands for none."""
    return NOTHING if value is None else format(value, spec)


def _velocity(values: Iterable[float] | None) -> str:
    if values is None:
        return NOTHING
    return " ".join(f"{round(value, 2) + 0.0:5.2f}" for value in values)  # no -0.00


def _scaled(value: float | None, size: float, spec: str = ".1f") -> str:
    return number(None if value is None else size * value, spec)


def _degrees(angle: float | None) -> str:
    return NOTHING if angle is None else f"{math.degrees(angle):.1f} deg"


def _solver(milliseconds: dict[str, float | None], failures: int | None) -> tuple[str, ...]:
    median, p95 = (number(milliseconds[key], ".2f") for key in ("median", "p95"))
    return f"{median} ms (median)", f"{p95} ms (95 %)", f"{number(failures)} failures"


def _edges(shares: dict[str, float | None]) -> tuple[str, ...]:
    return tuple(f"{name} {number(share, '.1%')}" for name, share in shares.items())


def _slowed(part: dict[str, Any]) -> str:
    return (
        f"to {part['speed']:.2f} m/s for {100.0 * part['share']:.0f} % of the time: {part['why']}"
    )


def _contact(contact: dict[str, float | None]) -> tuple[str, ...]:
    late = f"{number(contact['latency_ms'], '.1f')} ms late (median)"
    return (
        late,
        f"{number(contact['false_positives'])} false",
        f"{number(contact['missed'])} missed",
    )


def _rate(run: Run, name: str) -> float | None:
    """Return how often a channel has a value [Hz]; None when it has fewer than two."""
    values = flattened(getattr(run, name))
    times = run.time[~np.isnan(values).all(axis=1)]
    return 1.0 / float(np.median(np.diff(times))) if len(times) > 1 else None


def _read_mcap(file: Path) -> tuple[dict[str, int], int]:
    """Return the messages of each topic, and how many samples there are for one."""
    from mcap.reader import make_reader

    try:
        with file.open("rb") as stream:
            reader = make_reader(stream)
            summary = reader.get_summary()
            facts = {m.name: m.metadata for m in reader.iter_metadata()}
    except Exception as error:  # the reader raises all kinds for damaged files
        reason = getattr(error, "strerror", None) or str(error) or "ends too early"
        raise InputError(file, "", "log", f"cannot be read: {reason}") from error
    step = facts.get(METADATA, {}).get(STEP, "")
    if summary is None or summary.statistics is None or not (step.isdecimal() and len(step) < 20):
        raise InputError(file, f"metadata {METADATA}", step, "is none of this program")
    counts = summary.statistics.channel_message_counts
    messages = {channel.topic: counts.get(i, 0) for i, channel in summary.channels.items()}
    return messages, int(step)
