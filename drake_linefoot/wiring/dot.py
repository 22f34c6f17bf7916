"""A diagram's wiring in Graphviz's language."""

from collections.abc import Iterator, Mapping
from itertools import zip_longest

from jinja2 import Environment, PackageLoader, StrictUndefined

from drake_linefoot.wiring.graph import Block, Port, all_blocks
from drake_linefoot.wiring.ports import UNKNOWN, Signal

# Head and body of a block, by the part of the package (or Drake) that its class comes from.
COLOURS = {
    "pydrake": ("#4a6fa5", "#eef3fa"),
    "contact": ("#8a5a9e", "#f6f0f9"),
    "gait": ("#3d8361", "#edf6f1"),
    "reference": ("#3d8361", "#edf6f1"),
    "mpc": ("#b5602a", "#fbf1ea"),
    "wbc": ("#a83a4a", "#faeef0"),
}
OTHER = ("#5f6670", "#f2f3f5")

Facts = Mapping[Port, Signal]


def wiring_dot(
    wiring: Block, title: str, facts: Facts | None = None, *, details: bool = False
) -> str:
    """Return a drawing in Graphviz's language: data flows from top to bottom.

    It depends on what is given alone: no addresses, nothing of the machine.

    Args:
        wiring: what is drawn.
        title: above it.
        facts: of the ports; the rate at the end of a connection is written on it.
        details: whether the other facts are written under the names of the ports.
    """
    places = {
        port: f"{_quoted(block.path)}:{side}{row}"
        for block in all_blocks(wiring)
        if not block.blocks
        for side, ports in (("i", block.inputs), ("o", block.outputs))
        for row, port in enumerate(ports)
    }
    environment = Environment(
        loader=PackageLoader("drake_linefoot.wiring"),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    environment.filters["quoted"] = _quoted
    return environment.get_template("wiring.dot.j2").render(
        root=wiring,
        title=title,
        edges=_edges(wiring, facts or {}),
        details=facts if facts and details else {},
        place=places.get,
        zip_longest=zip_longest,
        colours=_colours,
    )


def _edges(wiring: Block, facts: Facts) -> Iterator[tuple[Port, Port, str, bool, str]]:
    """Yield the connections: source, target, colour, whether it leads back, rate.

    The colour is that of where the signal is made. A connection that leads back to an earlier
    block must not push that block down.
    """
    blocks = {block.path: block for block in (wiring, *all_blocks(wiring))}
    order = list(blocks)
    comes_from = {target: source for source, target in wiring.connections}
    for source, target in wiring.connections:
        origin = source
        while origin in comes_from:
            origin = comes_from[origin]
        outside = source.system.rpartition(".")[0] == target.system.rpartition(".")[0]
        earlier = order.index(target.system) <= order.index(source.system)
        back = outside and target.system != "" and earlier
        rate = facts[target].rate if target in facts else UNKNOWN
        yield source, target, _colours(blocks[origin.system])[0], back, rate


def _colours(block: Block) -> tuple[str, str]:
    """Return the colours of a block's head and body."""
    package, _, rest = block.kind.__module__.partition(".")
    part = rest.partition(".")[0]
    return COLOURS.get(package) or COLOURS.get(part) or OTHER


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
