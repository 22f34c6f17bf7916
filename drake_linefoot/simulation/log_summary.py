"""What is in the logs of a run: channels, units, shapes, rates, sizes."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drake_linefoot.errors import InputError
from drake_linefoot.simulation.mcap_log import METADATA
from drake_linefoot.simulation.output import MCAP
from drake_linefoot.simulation.recording import CHANNELS, DERIVED, LOG, Run


@dataclass(frozen=True)
class ChannelSummary:
    """One channel of a log.

    Attributes:
        name: in Python, and with a slash before it in MCAP.
        unit: see `Channel.unit`.
        shape: of one sample.
        samples: rows of the array; None when it is not in the npz.
        rate: of the values that are there [Hz]; None when there are fewer than two.
        kilobytes: what the npz keeps it in; None when it is not in the npz.
        messages: of the MCAP log; None when that is not there.
    """

    name: str
    unit: str
    shape: tuple[int, ...]
    samples: int | None
    rate: float | None
    kilobytes: float | None
    messages: int | None


@dataclass(frozen=True)
class LogSummary:
    """The logs of a run.

    Attributes:
        channels: by name, in the order of `Run`, then those derived from them.
        files: size of each log [MB] by its name.
        samples_per_message: of the MCAP log; None when that is not there.
    """

    channels: tuple[ChannelSummary, ...]
    files: dict[str, float]
    samples_per_message: int | None


def summarize_log(folder: str | Path) -> LogSummary:
    """Return what is in the logs of a run.

    Args:
        folder: what `linefoot walk` wrote.

    Raises:
        InputError: there is no log, or it cannot be read.
    """
    folder = Path(folder)
    run = Run.load(folder)
    with zipfile.ZipFile(folder / LOG) as archive:
        sizes = {i.filename.removesuffix(".npy"): i.compress_size for i in archive.infolist()}
    files, messages, step = {LOG: (folder / LOG).stat().st_size / 1e6}, None, None
    if (folder / MCAP).exists():
        files[MCAP] = (folder / MCAP).stat().st_size / 1e6
        messages, step = _read_mcap(folder / MCAP)
    channels = []
    for name, channel in (CHANNELS | DERIVED).items():
        values = getattr(run, name)
        stored = name in sizes
        channels.append(
            ChannelSummary(
                name=name,
                unit=channel.unit,
                shape=values.shape[1:],
                samples=len(values) if stored else None,
                rate=_rate(run, name),
                kilobytes=sizes[name] / 1e3 if stored else None,
                messages=None if messages is None else messages.get(f"/{name}"),
            )
        )
    return LogSummary(tuple(channels), files, step)


def _rate(run: Run, name: str) -> float | None:
    """Return how often a channel has a value [Hz]."""
    values = getattr(run, name).reshape(len(run.time), -1)
    times = run.time[~np.isnan(values).all(axis=1)]
    return 1.0 / float(np.median(np.diff(times))) if len(times) > 1 else None


def _read_mcap(file: Path) -> tuple[dict[str, int], int]:
    """Return the messages of each topic, and how many samples there are for one."""
    from mcap.exceptions import McapError
    from mcap.reader import make_reader

    try:
        with file.open("rb") as stream:
            reader = make_reader(stream)
            summary = reader.get_summary()
            facts = {m.name: m.metadata for m in reader.iter_metadata()}
    except (McapError, OSError, EOFError) as error:
        raise InputError(file, "", "log", f"cannot be read: {error or 'ends too early'}") from error
    if summary is None or summary.statistics is None or METADATA not in facts:
        raise InputError(file, "", "log", "is no log of this program")
    counts = summary.statistics.channel_message_counts
    messages = {channel.topic: counts.get(i, 0) for i, channel in summary.channels.items()}
    return messages, int(facts[METADATA]["samples_per_message"])
