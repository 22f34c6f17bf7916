"""Drawings of a diagram's wiring, or of one of its blocks: as text, SVG and PNG."""

import hashlib
import os
import warnings
from dataclasses import dataclass
from pathlib import Path

from pydrake.systems.framework import Diagram, System

from drake_linefoot.errors import InputError
from drake_linefoot.files import write_file
from drake_linefoot.resources import scenario_files
from drake_linefoot.scenario import Scenario
from drake_linefoot.scenario.load import load_scenario, scenario_file
from drake_linefoot.wiring.closed_loop import build_closed_loop
from drake_linefoot.wiring.dot import wiring_dot
from drake_linefoot.wiring.graph import Block, all_blocks, read_wiring
from drake_linefoot.wiring.ports import ports_text, wiring_facts

YAML = {".yaml", ".yml"}
PNG_RESOLUTION = 110  # [dots per inch]


@dataclass(frozen=True)
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
        alone = not self.wiring.connections
        return wiring_dot(self.wiring, "" if alone else self.name, facts, details=alone)

    @property
    def ports(self) -> str:
        """The tables of its ports."""
        return ports_text(self.wiring, self.name, self.scenario)


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
        return Picture(file.stem, read_wiring(build_closed_loop(loaded).diagram), loaded, file)
    loaded = load_scenario(scenario)
    blocks = list(all_blocks(read_wiring(build_closed_loop(loaded).diagram)))
    for block in blocks:
        if name in {block.path, block.name}:
            return Picture(block.name, read_wiring(block.system), loaded)
    systems = [block.path for block in blocks]
    allowed = f"no such scenario or system; must be one of {[*scenario_files(), *systems]}"
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

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about fonts, from the libraries below
        graph = pygraphviz.AGraph(string=dot)
        return graph.draw(format=form, prog="dot", args=arguments)
