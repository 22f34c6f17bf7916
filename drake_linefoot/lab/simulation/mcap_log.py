"""A run as an MCAP log, for Foxglove, PlotJuggler and whatever else reads MCAP.

Every channel of a `Run` but `time`, and `rpy`, is a topic under its own name (`/com`). A message
is JSON with one named number per entry; the topic's JSON schema says type and unit of each, and
so does the channel's metadata. Timestamps are simulated time from 0. A number that is NaN in the
run is left out of its message, and a message without any number is left out of the log. What a
3D panel shows is added by `mcap_scene`.
"""

from __future__ import annotations

import json
from typing import IO, TYPE_CHECKING, Any, NamedTuple

import numpy as np

from drake_linefoot import __version__
from drake_linefoot.errors import InputError
from drake_linefoot.lab.scenario.load import dump_scenario
from drake_linefoot.lab.simulation.channels import MODES, Channel
from drake_linefoot.lab.simulation.mcap_scene import Scene
from drake_linefoot.lab.simulation.recording import CHANNELS, DERIVED, Run
from drake_linefoot.lab.simulation.run_view import axis_names, flattened
from drake_linefoot.types import Array

if TYPE_CHECKING:
    from mcap.writer import Writer

MCAP = "log.mcap"  # the file, in the folder of a run
SLOWEST, FASTEST = 1e-3, 1e6  # [Hz]
RATE = 200.0  # [Hz] of the messages; the log has every sample
BLOCK = 8192  # samples whose messages are in memory together
METADATA, STEP, SCENARIO = "drake_linefoot", "samples_per_message", "scenario.yaml"
DESCRIPTIONS = {"mode": "of the gait: " + ", ".join(f"{i} {m}" for i, m in enumerate(MODES))}


def write_mcap(run: Run, content: IO[bytes], rate: float = RATE) -> None:
    """Write a run as an MCAP file, block by block.

    Args:
        run: what was recorded.
        content: of the file.
        rate: of the messages [Hz]: every sample or every second, third, ... one is taken, so that
            it is as near as possible. A channel that has fewer values than that (`mpc_ms`,
            once per plan) keeps them all.

    Raises:
        InputError: `rate` is not a number from 0.001 to 1e6, or the robot is another one now.
        ModelError: the robot of the run, which names the joints, cannot be read.
    """
    from mcap.writer import Writer

    if not SLOWEST <= rate <= FASTEST:
        allowed = f"must be a number from {SLOWEST:g} to {FASTEST:g}, in Hz"
        raise InputError("log", "rate", rate, allowed)
    writer = Writer(content)
    writer.start(library=f"drake_linefoot {__version__}")
    step = samples_for_one(run.time, rate)
    sized = axis_names(run)
    channels = {name: c for name, c in (CHANNELS | DERIVED).items() if name != "time"}
    scene = Scene(writer, run) if len(run.time) else None
    topics = {}
    for name, channel in channels.items():
        schema = {
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": name,
            "description": DESCRIPTIONS.get(name, f"unit: {channel.unit}"),
            **_schema(channel, channel.names(sized)),
        }
        kind = writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
        topic = writer.register_channel(f"/{name}", "json", kind, {"unit": channel.unit})
        form = _form(channel.names(sized) or [("value",)], "%d" if channel.is_whole else "%.6g")
        topics[name] = _Topic(topic, form, step if _is_dense(run, name, step) else 1)
    for begin in range(0, len(run.time), BLOCK):
        messages = [m for name, topic in topics.items() for m in _messages(run, name, topic, begin)]
        messages += scene.messages(begin, begin + BLOCK) if scene else []
        for time, number, data in sorted(messages, key=lambda m: m[:2]):
            writer.add_message(number, time, data, time)
    _describe(writer, run, step)
    writer.finish()


class _Topic(NamedTuple):
    """How the messages of a channel are made."""

    number: int
    form: str  # with places for numbers
    step: int  # samples for one message


def samples_for_one(time: Array, rate: float) -> int:
    """Return how many samples there are for one of a rate [Hz], as near as possible."""
    if len(time) < 2:
        return 1
    return max(1, round(1.0 / (rate * float(np.median(np.diff(time))))))


def _schema(channel: Channel, names: list[tuple[str, ...]], unit: str = "") -> dict[str, Any]:
    """Return the JSON schema of what is below the axes in front of `names`."""
    kind = "integer" if channel.is_whole else "number"
    if not names:
        unit = unit or channel.unit
        leaf = {"type": kind, "description": unit, "unit": unit}
        return leaf if channel.axes else {"type": "object", "properties": {"value": leaf}}
    first, *rest = names
    units = channel.entry_units(len(first)) if not rest else [""] * len(first)
    inner = {n: _schema(channel, rest, u) for n, u in zip(first, units, strict=True)}
    return {"type": "object", "properties": inner}


def _is_dense(run: Run, name: str, step: int) -> bool:
    """Whether a channel has a value more often than every `step` samples."""
    values, n = getattr(run, name), len(run.time)
    blocks = (flattened(values[i : i + BLOCK]) for i in range(0, n, BLOCK))
    count = sum(int(np.count_nonzero(np.isfinite(b).any(axis=1))) for b in blocks)
    return count * step > n


def _messages(run: Run, name: str, topic: _Topic, begin: int) -> list[tuple[int, int, bytes]]:
    """Return time [ns], topic and content of the messages of a channel in a block."""
    block = slice(begin, begin + BLOCK)
    time = run.time[block]
    values = flattened(getattr(run, name)[block])
    finite = np.isfinite(values)
    taken = np.flatnonzero(finite.any(axis=1))
    taken = taken[(taken + begin) % topic.step == 0]
    complete = finite[taken].all(axis=1)
    times = np.round(1e9 * time[taken]).astype(np.int64).tolist()
    rows = []
    for at, row, whole in zip(times, values[taken].tolist(), complete, strict=True):
        text = topic.form % tuple(row) if whole else _without_gaps(topic.form, row)
        rows.append((at, topic.number, text.encode()))
    return rows


def _form(names: list[tuple[str, ...]], number: str) -> str:
    """Return a message with places for its numbers."""
    if not names:
        return number
    first, *rest = names
    inner = _form(rest, number)
    return "{" + ",".join(json.dumps(n).replace("%", "%%") + ":" + inner for n in first) + "}"


def _without_gaps(form: str, row: list[float]) -> str:
    """Return a message without those of its numbers that are not finite."""

    def kept(value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        inner = {key: kept(entry) for key, entry in value.items()}
        return {key: entry for key, entry in inner.items() if entry not in (None, {})}

    filled = form.replace("%d", "%s").replace("%.6g", "%s")
    texts = (f"{value:.6g}" if np.isfinite(value) else "null" for value in row)
    return json.dumps(kept(json.loads(filled % tuple(texts))), separators=(",", ":"))


def _describe(writer: Writer, run: Run, step: int) -> None:
    """Add what is said once: scenario, version, robot, how it ended."""
    facts = {
        "version": run.version,
        "scenario": run.scenario.name,
        "robot": run.scenario.robot,
        STEP: str(step),
        "fell": str(run.fell).lower(),
        "fall_time": "" if run.fall_time is None else f"{run.fall_time:.3f} s",
        "fall_reason": run.fall_reason,
    }
    writer.add_metadata(METADATA, facts)
    scenario = dump_scenario(run.scenario).encode()
    writer.add_attachment(0, 0, SCENARIO, "application/yaml", scenario)
