"""A diagram's wiring in Graphviz's language."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping

from drake_linefoot.wiring.graph import Block, Port, Wiring
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
GROUP = ("#9aa5b1", "#fafbfc")  # border and background of what is inside a diagram
FONT, SMALL, FAINT = "Helvetica", 10, "#59636e"  # size and colour of what is less important


Facts = Mapping[Port, Signal]


def wiring_dot(
    wiring: Wiring, title: str, facts: Facts | None = None, *, details: bool = False
) -> str:
    """Return a drawing in Graphviz's language: data flows from left to right.

    It depends on what is given alone: no addresses, nothing of the machine.

    Args:
        wiring: what is drawn.
        title: above it.
        facts: of the ports; the rate at the end of a connection is written on it.
        details: whether the other facts are written under the names of the ports.
    """
    facts = facts or {}
    written = facts if details else {}
    lines = [
        "digraph wiring {",
        f'  rankdir=LR; newrank=true; nodesep=0.3; ranksep=0.8; fontname="{FONT}";',
        f"  label={_quoted(title)}; labelloc=t; fontsize=20;",
        f'  node [shape=plain, fontname="{FONT}", fontsize=12];',
        f'  edge [arrowsize=0.7, penwidth=1.2, fontname="{FONT}", fontsize={SMALL}];',
        *_ports(wiring.root.inputs, "  "),
    ]
    blocks = _in_order(wiring.root, wiring)
    simulated = [block for block in blocks if _is_drakes(block)]
    for block in blocks:
        if block not in simulated:
            lines += _draw(block, wiring, "  ", written)
    inside = [_draw(block, wiring, "    ", written) for block in simulated]
    lines += _frame("", "simulated by Drake", inside, "  ")
    lines += _ports(wiring.root.outputs, "  ")
    lines += _edges(wiring, facts)
    return "\n".join([*lines, "}"]) + "\n"


def _in_order(parent: Block, wiring: Wiring) -> list[Block]:
    """Return the blocks inside `parent` in the order of the data, as far as loops allow.

    The next one is always the block that waits for the fewest others; of equals, the one
    that feeds most, and then the first by name.
    """
    blocks = {block.path: block for block in parent.blocks}
    pairs = {(a.system, b.system) for a, b in wiring.connections if a.system != b.system}
    pairs = {(a, b) for a, b in pairs if a in blocks and b in blocks}
    order: list[str] = []
    while len(order) < len(blocks):
        rest = [path for path in blocks if path not in order]

        def rank(path: str, rest: list[str] = rest) -> tuple[int, int, str]:
            waits = sum(a in rest for a, b in pairs if b == path)
            feeds = sum(b in rest for a, b in pairs if a == path)
            return waits, -feeds, path

        order.append(min(rest, key=rank))
    return [blocks[path] for path in order]


def _edges(wiring: Wiring, facts: Facts) -> list[str]:
    """Return the lines of the connections, each in the colour of where its signal is made.

    One that leads back to an earlier block must not push that block to the right.
    """
    order: dict[str, int] = {}
    places: dict[Port, str] = {}
    colours: dict[str, str] = {}
    for block in _all_blocks(wiring.root, wiring):
        order[block.path] = len(order)
        colours[block.path] = _colours(block)[0]
        places |= _places(block)
    comes_from = {target: source for source, target in wiring.connections}
    lines = []
    for source, target in wiring.connections:
        origin = source
        while origin in comes_from:
            origin = comes_from[origin]
        outside = source.system.rpartition(".")[0] == target.system.rpartition(".")[0]
        back = outside and target.system != "" and order[target.system] <= order[source.system]
        style = f'color="{colours[origin.system]}"' + (", constraint=false" if back else "")
        if target in facts and facts[target].rate != UNKNOWN:
            label, colour = _quoted(facts[target].rate), colours[origin.system]
            style += f', label={label}, fontcolor="{colour}"'
        lines.append(f"  {places[source]}:e -> {places[target]}:w [{style}];")
    return lines


def _all_blocks(block: Block, wiring: Wiring) -> Iterator[Block]:
    yield block
    for child in _in_order(block, wiring):
        yield from _all_blocks(child, wiring)


def _draw(block: Block, wiring: Wiring, indent: str, written: Facts) -> list[str]:
    """Return the lines of a block: a table, or a frame around what is inside."""
    if not block.blocks:
        return [f"{indent}{_quoted(block.path)} [label=<{_table(block, written)}>];"]
    inner = indent + "  "
    children = [_draw(child, wiring, inner, written) for child in _in_order(block, wiring)]
    content = [_ports(block.inputs, inner), *children, _ports(block.outputs, inner)]
    return _frame(block.path, block.name, content, indent)


def _frame(path: str, label: str, content: list[list[str]], indent: str) -> list[str]:
    """Return the lines of a frame around `content`, nothing around nothing."""
    if not content:
        return []
    border, background = GROUP
    return [
        f"{indent}subgraph {_quoted('cluster ' + path)} {{",
        f"{indent}  label={_quoted(label)}; labeljust=l; labelloc=b; fontsize=16; margin=14;",
        f'{indent}  style="rounded,filled"; color="{border}"; fillcolor="{background}";',
        *(line for lines in content for line in lines),
        f"{indent}}}",
    ]


def _is_drakes(block: Block) -> bool:
    """Whether a block is one of Drake's own, not made of this package's."""
    return not block.blocks and block.module.startswith("pydrake.")


def _ports(ports: tuple[Port, ...], indent: str) -> list[str]:
    """Return the lines of exported ports, which are nodes of their own, one above the other."""
    if not ports:
        return []
    style = f'shape=box, style="rounded,filled", fillcolor=white, color="{GROUP[0]}", height=0.3'
    nodes = "; ".join(f"{_exported(port)} [label={_quoted(port.name)}, {style}]" for port in ports)
    return [f"{indent}{{ rank=same; {nodes}; }}"]


def _colours(block: Block) -> tuple[str, str]:
    """Return the colours of a block's head and body."""
    package, _, rest = block.module.partition(".")
    part = rest.partition(".")[0]
    return COLOURS.get(package) or COLOURS.get(part) or OTHER


def _table(block: Block, written: Facts) -> str:
    """Return a block as an HTML-like label: its name, inputs left, outputs right."""
    head, body = _colours(block)
    rows = []
    for i in range(max(len(block.inputs), len(block.outputs))):
        cells = [
            _cell(ports[i] if i < len(ports) else None, f"{side}{i}", align, written)
            for ports, side, align in (
                (block.inputs, "i", "left"),
                (block.outputs, "o", "right"),
            )
        ]
        rows.append(f"<tr>{''.join(cells)}</tr>")
    title = f'<font color="white"><b>{html.escape(block.name)}</b></font>'
    return (
        f'<table border="1" color="{head}" bgcolor="{body}" cellborder="0" cellspacing="0" '
        f'cellpadding="5"><tr><td colspan="2" bgcolor="{head}">{title}</td></tr>'
        f"{''.join(rows)}</table>"
    )


def _cell(port: Port | None, place: str, align: str, written: Facts) -> str:
    if port is None:
        return "<td></td>"
    text = html.escape(port.name)
    if port in written:
        known = [word for word in written[port] if word != UNKNOWN]
        small = (
            f'<font point-size="{SMALL}" color="{FAINT}">{html.escape(" · ".join(known))}</font>'
        )
        lines = (f'<tr><td align="{align}">{line}</td></tr>' for line in (text, small))
        text = f'<table border="0" cellspacing="0" cellpadding="1">{"".join(lines)}</table>'
    return f'<td port="{place}" align="{align}">{text}</td>'


def _places(block: Block) -> dict[Port, str]:
    """Return where in the drawing the ports of a block are."""
    places = {}
    for side, ports in (("i", block.inputs), ("o", block.outputs)):
        for row, port in enumerate(ports):
            inside = f"{_quoted(block.path)}:{side}{row}"
            places[port] = _exported(port) if block.blocks else inside
    return places


def _exported(port: Port) -> str:
    return _quoted(f"{port} {'in' if port.is_input else 'out'}")


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
