"""Drawings say what is connected to what, and the committed ones are up to date."""

import re
import sys
import xml.etree.ElementTree as ET

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, Gain, PassThrough

from drake_linefoot.errors import OutputError
from drake_linefoot.resources import diagrams_dir
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.scenario_io import load_scenario, shipped_scenarios
from drake_linefoot.wiring import draw
from drake_linefoot.wiring.closed_loop import build_closed_loop
from drake_linefoot.wiring.controller import build_controller
from drake_linefoot.wiring.graph import read_wiring

SVG = "{http://www.w3.org/2000/svg}"
DRAWN = sorted(path.stem for path in diagrams_dir().glob("*.txt"))


def inner():
    """A diagram with one exported input, read twice, and one exported output."""
    builder = DiagramBuilder()
    gain = builder.AddNamedSystem("gain", Gain(2.0, 1))
    adder = builder.AddNamedSystem("adder", Adder(2, 1))
    builder.Connect(gain.get_output_port(), adder.get_input_port(0))
    value = builder.ExportInput(gain.get_input_port(), "value")
    builder.ConnectInput(value, adder.get_input_port(1))
    builder.ExportOutput(adder.get_output_port(), "result")
    diagram = builder.Build()
    diagram.set_name("inner")
    return diagram


def outer():
    """A source, the inner diagram in a loop with nothing, and an exported output."""
    builder = DiagramBuilder()
    sink = builder.AddNamedSystem("a_sink", PassThrough(1))
    nested = builder.AddSystem(inner())
    source = builder.AddNamedSystem("source", ConstantVectorSource([1.0]))
    builder.Connect(source.get_output_port(), nested.get_input_port())
    builder.Connect(nested.get_output_port(), sink.get_input_port())
    builder.ExportOutput(sink.get_output_port(), "out")
    builder.AddNamedSystem("alone", Gain(1.0, 1))
    return builder.Build()


OUTER = """\
a_sink.y -> output.out
inner.adder.sum -> inner.result
inner.gain.y0 -> inner.adder.u0
inner.result -> a_sink.u
inner.value -> inner.adder.u1
inner.value -> inner.gain.u0
source.y0 -> inner.value
"""


@pytest.fixture(scope="module")
def walk():
    return read_wiring(build_closed_loop(load_scenario("walk")).diagram)


@pytest.fixture(scope="module")
def walk_dot(walk):
    return draw.wiring_dot(walk, "walk")


def texts(svg):
    return [node.text for node in ET.fromstring(svg).iter(f"{SVG}text")]


def test_text_has_nested_and_exported_ports():
    assert draw.wiring_text(read_wiring(outer())) == OUTER


def test_exported_input_of_the_root():
    assert "input.value -> gain.u0\n" in draw.wiring_text(read_wiring(inner()))


def test_unconnected_ports_and_diagrams_without_connections():
    builder = DiagramBuilder()
    builder.AddNamedSystem("alone", Gain(1.0, 1))
    wiring = read_wiring(builder.Build())
    assert draw.wiring_text(wiring) == ""
    assert [(b.name, b.inputs, b.outputs) for b in wiring.root.blocks] == [("alone", (), ())]
    assert "alone" in texts(draw.render_svg(draw.wiring_dot(wiring, "x")))


def test_blocks_are_drawn_in_the_order_of_the_data():
    dot = draw.wiring_dot(read_wiring(outer()), "x")
    assert dot.index('"inner.gain" [') < dot.index('"inner.adder" [')
    assert dot.index('"source" [') < dot.index('"a_sink" [')


def test_drawing_is_the_same_every_time_and_holds_no_address(walk_dot):
    again = draw.wiring_dot(read_wiring(build_closed_loop(load_scenario("walk")).diagram), "walk")
    assert again == walk_dot
    assert "0x" not in walk_dot
    assert draw.render_svg(walk_dot) == draw.render_svg(walk_dot)


def test_loops_do_not_push_blocks_to_the_right(walk_dot):
    back = {line.split(" [")[0].strip() for line in walk_dot.splitlines() if "constraint" in line}
    assert {edge.split(":")[0] for edge in back} == {'"plant"', '"scene_graph"'}
    assert sum("controller.state in" in edge for edge in back) == 1


def test_edges_have_the_colour_of_the_block_that_makes_the_signal(walk_dot):
    red = draw.COLOURS["wbc"][0]
    (line,) = [x for x in walk_dot.splitlines() if '-> "plant"' in x and "controller.torque" in x]
    assert f'color="{red}"' in line


def test_svg_shows_every_port_and_block(walk, walk_dot):
    shown = texts(draw.render_svg(walk_dot))
    ports = [port for pair in walk.connections for port in pair]
    assert {port.name for port in ports} <= set(shown)
    names = {part for port in ports for part in port.system.split(".")}
    assert names <= set(shown)
    assert shown.count("state") == 8  # of five blocks, the controller, the plant, the recorder


def test_odd_names_are_drawn_as_they_are():
    builder = DiagramBuilder()
    builder.AddNamedSystem('a "b" <c> & d', Gain(1.0, 1))
    dot = draw.wiring_dot(read_wiring(builder.Build()), 'title "x" <y>')
    assert {'a "b" <c> & d', 'title "x" <y>'} <= set(texts(draw.render_svg(dot)))


def test_controller_alone_is_drawn_too():
    scenario = load_scenario("walk")
    diagram = build_controller(load_humanoid(scenario.robot), scenario)
    text = draw.wiring_text(read_wiring(diagram))
    assert "input.state -> ecd_mpc.state\n" in text
    assert "whole_body_controller.torque -> output.torque\n" in text


def test_every_connection_of_the_loop_is_in_the_text(walk):
    lines = set(draw.wiring_text(walk).splitlines())
    assert {
        "command.command -> controller.command",
        "plant.state -> controller.state",
        "plant.net_actuation -> controller.applied_torque",
        "controller.torque -> plant.actuation",
        "controller.ecd_mpc.plan -> controller.whole_body_controller.plan",
    } <= lines


def test_without_pygraphviz_the_dot_is_written(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "pygraphviz", None)
    files = draw.draw(load_scenario("stand"), "stand", tmp_path / "new")
    assert [file.name for file in files] == ["stand.txt", "stand.dot"]
    assert files[1].read_text(encoding="utf-8").startswith("digraph wiring {")


def test_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=r"walk\.txt: cannot be written"):
        draw.draw(load_scenario("walk"), "walk", tmp_path / "file")


def test_every_scenario_is_drawn():
    assert shipped_scenarios() == DRAWN


@pytest.mark.parametrize("name", DRAWN)
def test_committed_drawing_is_up_to_date(name):
    """When this fails, run `linefoot draw NAME` and commit what it writes."""
    wiring = read_wiring(build_closed_loop(load_scenario(name)).diagram)
    text = (diagrams_dir() / f"{name}.txt").read_text(encoding="utf-8")
    assert text == draw.wiring_text(wiring)
    svg = (diagrams_dir() / f"{name}.svg").read_text(encoding="utf-8")
    (fingerprint,) = re.findall(r"^<!-- .* wiring (\w+) -->$", svg, flags=re.M)
    assert fingerprint == draw.fingerprint(draw.wiring_dot(wiring, name))
    assert sorted(texts(svg)) == sorted(texts(draw.render_svg(draw.wiring_dot(wiring, name))))


def test_glossary_has_every_port_of_the_walk_and_no_other(walk):
    readme = (diagrams_dir() / "README.md").read_text(encoding="utf-8")
    written = set()
    for section in readme.split("\n### ")[1:]:
        system = section.split("\n", 1)[0].strip()
        for name, way in re.findall(r"^\| `(\w+)` \| (in|out) \|", section, flags=re.M):
            written.add((system, name, way == "in"))
    used = {(p.system, p.name, p.is_input) for pair in walk.connections for p in pair}
    assert written == used
