"""Drawings of a diagram's wiring, or of one of its blocks: as text, SVG and PNG."""

import hashlib
import os
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from pydrake.systems.framework import Diagram, System

from drake_linefoot.errors import InputError
from drake_linefoot.files import write_file
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import load_scenario, scenario_file
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.lab.wiring.graph import Block, Port, all_blocks, read_wiring
from drake_linefoot.lab.wiring.ports import UNKNOWN, Signal, ports_text, wiring_facts
from drake_linefoot.resources import scenario_files

YAML = {".yaml", ".yml"}
PNG_RESOLUTION = 110  # [dots per inch]
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
STYLE = """nodesep=0.05; ranksep=0.2; fontname="Helvetica";
node [fontname="Helvetica", fontsize=13];
edge [arrowsize=0.7, penwidth=1.2, fontname="Helvetica", fontsize=12];"""

Facts = Mapping[Port, Signal]


@dataclass(frozen=True, repr=False)
class Picture:
    """What can be drawn.

    Attributes:
        name: of the files and the title.
        wiring: what is in it.
        scenario: with which parameters; gives the rates.
        file: the scenario that is drawn whole; None when it is one of its systems.
    """

    name: str
    wiring: Block
    scenario: Scenario
    file: Path | None = None

    @property
    def dot(self) -> str:
        """The drawing in Graphviz's language."""
        facts = wiring_facts(self.wiring, self.scenario)
        return wiring_dot(self.wiring, self.name, facts, details=not self.wiring.connections)

    @property
    def ports(self) -> str:
        """The tables of its ports."""
        return ports_text(self.wiring, self.name, self.scenario)

    def __repr__(self) -> str:
        """Return what it is of; where it can be drawn, a notebook shows `_repr_svg_`."""
        return f"Picture of {self.name!r}: draw(picture, folder) writes it"

    def _repr_svg_(self) -> str | None:
        """Return it as an SVG; None without Graphviz."""
        return render_svg(self.dot)


def picture_of(name: str, scenario: str = "walk") -> Picture:
    """Return the closed loop of a scenario (without pictures), or one of its systems alone.

    Args:
        name: of a shipped scenario, or a YAML file; else a system of the closed loop, by its
            path (`controller.ecd_mpc`) or the path's end (`ecd_mpc`).
        scenario: whose closed loop the system is taken from.

    Raises:
        InputError: there is nothing of that name, or the closed loop cannot be built.
    """
    if name in scenario_files() or Path(name).suffix in YAML or os.path.isfile(name):
        file = scenario_file(name)
        loaded = load_scenario(file)
        return Picture(file.stem, read_wiring(build_closed_loop(loaded)), loaded, file)
    loaded = load_scenario(scenario)
    return picture_of_part(build_closed_loop(loaded), loaded, name, list(scenario_files()))


def picture_of_part(
    diagram: Diagram, scenario: Scenario, name: str = "", others: Sequence[str] = ()
) -> Picture:
    """Return a diagram, or one of its systems, to be drawn.

    Args:
        diagram: whole, or what the system is in.
        scenario: gives the rates.
        name: of the system, see `picture_of`.
        others: names that a message of an error says as well.

    Raises:
        InputError: there is no such system.
    """
    if not name:
        return picture_of_system(diagram, scenario)
    blocks = list(all_blocks(read_wiring(diagram)))
    for block in blocks:
        if name in {block.path, block.name}:
            return Picture(block.name, read_wiring(block.system), scenario)
    systems = [*others, *(block.path for block in blocks)]
    allowed = f"no such {'scenario or ' * bool(others)}system; must be one of {systems}"
    raise InputError("draw", "", name, allowed)


def picture_of_system(system: System, scenario: Scenario | None = None) -> Picture:
    """Return a system of one's own, to be drawn; `scenario` gives the rates."""
    kind = "diagram" if isinstance(system, Diagram) else type(system).__name__
    return Picture(system.get_name() or kind, read_wiring(system), scenario or Scenario())


def draw(picture: Picture, folder: str | Path, *, png: bool = False) -> list[Path]:
    """Write a drawing into a folder.

    Args:
        picture: what is drawn.
        folder: where to; made when missing.
        png: whether there shall be a PNG as well.

    Returns:
        The files: NAME.svg (NAME.dot where pygraphviz is not installed), before it NAME.txt
        when there are connections, after it NAME.png.

    Raises:
        OutputError: a file cannot be written.
    """
    name, dot = picture.name, picture.dot
    files: dict[str, bytes] = {}
    if picture.wiring.connections:
        files[f"{name}.txt"] = wiring_text(picture.wiring).encode()
    svg = render_svg(dot)
    if svg is None:
        files[f"{name}.dot"] = dot.encode()
    else:
        files[f"{name}.svg"] = svg.encode()
        if png:
            files[f"{name}.png"] = _render(dot, "png", f"-Gdpi={PNG_RESOLUTION}")
    written = []
    for file, content in files.items():
        written.append(Path(folder) / file)
        write_file(written[-1], content)
    return written


def wiring_text(wiring: Block) -> str:
    """Return one connection per line, `system.port -> system.port`, sorted."""
    return "".join(f"{source} -> {target}\n" for source, target in wiring.connections)


def fingerprint(dot: str) -> str:
    """Return what tells one drawing from another, whatever program and fonts rendered it."""
    return hashlib.sha256(dot.encode()).hexdigest()


def render_svg(dot: str) -> str | None:
    """Return the SVG of a drawing, with its fingerprint in a comment; None without Graphviz."""
    try:
        svg = _render(dot, "svg").decode()
    except ImportError:
        return None
    start = svg.index("<svg")
    return f"<!-- drawn by `linefoot draw`; wiring {fingerprint(dot)} -->\n{svg[start:]}"


def _render(dot: str, form: str, arguments: str = "") -> bytes:
    """Return a drawing as a file of a form; ImportError when pygraphviz is not installed."""
    import pygraphviz

    with warnings.catch_warnings(), _without_stderr():
        warnings.simplefilter("ignore")  # about fonts, from the libraries below
        graph = pygraphviz.AGraph(string=dot)
        return graph.draw(format=form, prog="dot", args=arguments)


@contextmanager
def _without_stderr() -> Iterator[None]:
    """Let nothing be said on stderr in the `with` block, as Fontconfig does of its files."""
    sys.stderr.flush()
    kept = os.dup(2)
    try:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), 2)
            yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def wiring_dot(wiring: Block, title: str, facts: Facts, *, details: bool = False) -> str:
    """Return a drawing in Graphviz's language: blocks, and between them what they pass on.

    It depends on what is given alone: no addresses, nothing of the machine. A diagram inside is
    one block. Under the name of a signal stand its type, size and rate, with `details` all facts;
    on a line that leads to a port of another name, the name of the port.
    """
    signals: dict[Port, list[Port]] = {}  # what reads each of them
    for source, target in _top_level(wiring):
        signals.setdefault(source, []).append(target)
    lines = [f"label={_quoted(title)}; labelloc=t; fontsize=20;" + details * " rankdir=LR;"]
    colours = {block.path: _colours(block) for block in wiring.blocks}
    for block in wiring.blocks:
        head, body = colours[block.path]
        look = f'shape=box, style=filled, color="{head}", fillcolor="{body}", penwidth=2'
        lines.append(f"{_quoted(block.path)} [label={_quoted(block.name)}, {look}];")
    for source, targets in signals.items():
        words = _words(source, facts[source if source in facts else targets[0]], details)
        from_outside, to_outside = not source.system, not all(t.system for t in targets)
        look = 'shape=box, style="rounded,filled", fillcolor=white, color="#9aa5b1"'
        look = look if from_outside or to_outside else "shape=plain"
        name = _quoted(str(source))
        lines.append(f'{name} [label={_quoted(source.name)[:-1]}\\n{words}", {look}];')
        colour = colours.get(source.system, OTHER)[0]
        if not from_outside:
            lines.append(f'{_quoted(source.system)} -> {name} [color="{colour}", dir=none];')
        for target in targets:
            if target.system:
                port = "" if target.name == source.name else f", label={_quoted(target.name)}"
                lines.append(f'{name} -> {_quoted(target.system)} [color="{colour}"{port}];')
    return "\n".join(["digraph wiring {", STYLE, *lines, "}\n"])


def _top_level(wiring: Block) -> Iterator[tuple[Port, Port]]:
    """Yield the connections between the blocks, and of a block alone those with nothing."""
    for source, target in wiring.connections:
        if "." not in source.system + target.system:
            yield source, target
    for block in wiring.blocks if not wiring.connections else ():
        yield from ((replace(port, system=""), port) for port in block.inputs)
        yield from ((port, replace(port, system="")) for port in block.outputs)


def _words(port: Port, signal: Signal, details: bool) -> str:
    """Return what stands under the name of a signal."""
    size = "" if port.size is None else f" {port.size}"
    if not details:
        return f"{signal.type}{size}\\n{signal.rate}"
    return " · ".join(word for word in signal if word != UNKNOWN)


def _colours(block: Block) -> tuple[str, str]:
    """Return the colours of a block's frame and body."""
    package, _, rest = block.kind.__module__.partition(".")
    part = rest.partition(".")[0]
    return COLOURS.get(package) or COLOURS.get(part) or OTHER


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
