"""What goes through every port: its type, shape, unit, frame, rate.

A port's name says what it carries, in every block that has a port of that name, so each name is
explained once: what the controller's blocks say to each other in `drake_linefoot.signals`, all else
here. The tables of `linefoot draw --ports` and the rates in the drawings come from there and here.
"""

import inspect
from collections.abc import Iterator
from typing import Any, NamedTuple

from drake_linefoot.lab.plants.contact_forces import FootContacts
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.wiring.graph import Block, Port, all_blocks
from drake_linefoot.layout import parts_of
from drake_linefoot.signals import SIGNALS as OF_CONTROLLER
from drake_linefoot.terrain import Terrain

TICK, PLAN, SEGMENTS, ASKED = "tick", "plan", "segments", "asked"
UNKNOWN = "-"


class Signal(NamedTuple):
    """What a port of some name carries, in words; "-" for what is not known.

    Attributes:
        type: "vector" is Drake's BasicVector, as is one with the name of a signal; others are
            classes of Drake.
        shape: of its numbers.
        unit: of its numbers.
        frame: they are expressed in.
        rate: how often there is a new value; in `SIGNALS`, `TICK` is once per plant step, `PLAN`
            once per plan of the MPC, `SEGMENTS` with the segments of the scenario, `ASKED` when
            asked for.
    """

    type: str
    shape: str
    unit: str
    frame: str
    rate: str = TICK


DECLARED = OF_CONTROLLER | {"foot_contacts": FootContacts, "terrain": Terrain}  # each part of them
PLANNED = ("horizon", "reference", "plan")  # signals that the MPC's rate has


def declared(name: str) -> Signal:
    """Return what is known of a port of `DECLARED`."""
    kind = DECLARED[name]
    parts = parts_of(kind).values()
    frames = dict.fromkeys(frame for part in parts for frame in part.frame.split(", ") if frame)
    rate = PLAN if name in PLANNED else TICK
    return Signal(kind.__name__, f"{len(parts)} parts", "by part", ", ".join(frames), rate)


SIGNALS: dict[str, Signal] = {name: declared(name) for name in DECLARED} | {
    "state": Signal("vector", "nq + nv", "m, rad; m/s, rad/s", "W, B, joints"),
    "measured": Signal("vector", "nq + nv", "m, rad; m/s, rad/s", "W, B, joints"),
    "noise": Signal("vector", "2 na + 12", "-", "-"),
    "angular_velocity": Signal("vector", "3", "rad/s", "B"),
    "specific_force": Signal("vector", "3", "m/s^2", "B"),
    "imu": Signal("vector", "6", "rad/s, m/s^2", "B"),
    "encoders": Signal("vector", "na", "rad", "joints"),
    "covariance": Signal("vector", "27 x 27", "-", "W"),
    "command": Signal("vector", "4", "m/s, m/s, rad/s, walk 0 or 1", "H", SEGMENTS),
    "torque": Signal("vector", "na", "N m", "joints"),
    "actuation": Signal("vector", "na", "N m", "joints"),
    "applied_torque": Signal("vector", "na", "N m", "joints"),
    "net_actuation": Signal("vector", "na", "N m", "joints"),
    "contact_results": Signal("ContactResults", "touching points", "N, m", "W"),
    "contacts": Signal("vector", "32 x 8", "side, N, m, m/s", "W"),
    "push": Signal("vector", "3", "N", "W"),
    "force": Signal("list of ExternallyAppliedSpatialForce", "one", "N, N m", "W"),
    "applied_spatial_force": Signal("list of ExternallyAppliedSpatialForce", "-", "N, N m", "W"),
    "geometry_query": Signal("QueryObject", "-", "m", "W"),
    "query": Signal("QueryObject", "-", "m", "W"),
    "geometry_pose": Signal("FramePoseVector", "bodies", "m", "W", ASKED),
    "plant_pose": Signal("FramePoseVector", "bodies", "m", "W", ASKED),
    "deformable_body_configuration": Signal("GeometryConfigurationVector", "0", "m", "W", ASKED),
    "plant_configuration": Signal("GeometryConfigurationVector", "0", "m", "W", ASKED),
}

# Class of a block and a port of its that has another meaning there.
OWN: dict[tuple[str, str], Signal] = {
    ("StateEstimator", "report"): SIGNALS["estimate"],
    ("LatePlan", "newest"): SIGNALS["plan"],
    ("Onboard", "noise"): Signal("vector", "na + 12", "-", "-"),
}

# Class of a block and its input port -> how often it reads it, where that is less often.
READ: dict[tuple[str, str], str] = {
    ("CentroidalReference", "dynamics"): PLAN,
    ("EcdMpc", "dynamics"): PLAN,
}

DRAKES = {
    "Accelerometer": "Specific force in the base frame: acceleration less gravity.",
    "Gyroscope": "Angular velocity in the base frame.",
    "Diagram": "The blocks inside it as one; its ports are theirs.",
    "MultibodyPlant": "The robot on its ground, in steps of `plant.time_step`.",
    "RandomSource": "Standard normal numbers, new ones in every plant step.",
    "SceneGraph": "Where the geometry is, for contact and pictures.",
}

COLUMNS = ("port", "", "type", "shape", "unit", "frame", "rate")
PARTS = ("part", "shape", "unit", "frame", "what it is")  # of a signal


def port_facts(block: Block, port: Port, scenario: Scenario) -> Signal:
    """Return what is known of a port of a block."""
    signal = OWN.get((block.kind.__name__, port.name), SIGNALS.get(port.name))
    vectors = {"vector", *(kind.__name__ for kind in DECLARED.values())}
    if signal is None or (signal.type in vectors) != (port.size is not None):
        size = UNKNOWN if port.size is None else str(port.size)
        return Signal("vector" if port.size else "other", size, UNKNOWN, UNKNOWN, UNKNOWN)
    rate = READ.get((block.kind.__name__, port.name), signal.rate)
    shape = signal.shape
    if port.size is not None and shape != str(port.size):
        shape = f"{shape} = {port.size}"
    return signal._replace(shape=shape, rate=rate_in_words(rate, scenario))


def rate_in_words(rate: str, scenario: Scenario) -> str:
    """Return a rate for people, for instance "50 Hz"."""
    if rate == SEGMENTS:
        return "per segment"
    if rate == ASKED:
        return "when asked"
    frequency = 1.0 / (scenario.plant.time_step if rate == TICK else scenario.mpc.period)
    return f"{1e-3 * frequency:.4g} kHz" if frequency > 999.0 else f"{frequency:.4g} Hz"


def wiring_facts(wiring: Block, scenario: Scenario) -> dict[Port, Signal]:
    """Return what is known of every port of a wiring."""
    return {
        port: port_facts(block, port, scenario)
        for block in (wiring, *all_blocks(wiring))
        for port in (*block.inputs, *block.outputs)
    }


def ports_text(wiring: Block, title: str, scenario: Scenario) -> str:
    """Return the tables of the ports of every block, in Markdown that is readable as it is."""
    lines, said = [f"# Ports of {title}"], set[str]()
    root = [wiring] if wiring.inputs or wiring.outputs else []
    for block in (*root, *sorted(all_blocks(wiring), key=lambda b: b.path.split("."))):
        if block.inputs or block.outputs:
            rows = [COLUMNS, *_rows(block, scenario)]
            name = "" if block is wiring and root else f"\n## {block.path}\n"
            lines += [*([name] if name else []), _about(block), "", *_table(rows)]
            said |= {row[2].strip() for row in rows}
    for kind in DECLARED.values():
        if kind.__name__ in said:
            about = (inspect.getdoc(kind) or "").partition("\n")[0]
            lines += [f"\n## {kind.__name__}\n", about, "", *_table([PARTS, *_parts(kind)])]
    return "\n".join(lines) + "\n"


def _about(block: Block) -> str:
    name, (package, _, module) = block.kind.__name__, block.kind.__module__.partition(".")
    if package == "pydrake":
        return f"Drake's `{name}`: {DRAKES.get(name, 'see its documentation.')}"
    about = (inspect.getdoc(block.kind) or "").partition("\n")[0]
    return f"`{module}.{name}`: {about}"


def _rows(block: Block, scenario: Scenario) -> Iterator[tuple[str, ...]]:
    for way, ports in (("in", block.inputs), ("out", block.outputs)):
        for port in ports:
            yield f"`{port.name}`", way, *port_facts(block, port, scenario)


def _parts(kind: type[Any]) -> Iterator[tuple[str, ...]]:
    for name, part in parts_of(kind).items():
        lengths = [str(len(axis) if isinstance(axis, tuple) else axis) for axis in part.axes]
        shape = " x ".join(f"({n})" if " " in n and len(lengths) > 1 else n for n in lengths)
        yield f"`{name}`", shape or "1", part.unit, part.frame or UNKNOWN, part.meaning


def _table(rows: list[tuple[str, ...]]) -> Iterator[str]:
    """Yield the lines of a table with columns of even width."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for i, row in enumerate(rows):
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        yield f"| {' | '.join(cells)} |".rstrip()
        if i == 0:
            yield "|" + "|".join("-" * (width + 2) for width in widths) + "|"
