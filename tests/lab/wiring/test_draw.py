"""Drawings say what is connected to what, and the committed ones are up to date."""

import re
import sys
import xml.etree.ElementTree as ET

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, Gain, PassThrough

from drake_linefoot.errors import InputError, OutputError
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.wiring.draw import COLOURS, picture_of, picture_of_system, wiring_dot
from drake_linefoot.lab.wiring.graph import read_wiring
from drake_linefoot.resources import diagrams_dir, scenario_files
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.wiring import draw
from drake_linefoot.wiring.controller import build_controller

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
def picture():
    return picture_of("walk")


@pytest.fixture(scope="module")
def walk(picture):
    return picture.wiring


@pytest.fixture(scope="module")
def walk_dot(picture):
    return picture.dot


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
    assert [(b.name, b.inputs, b.outputs) for b in wiring.blocks] == [("alone", (), ())]
    assert "alone" in texts(draw.render_svg(wiring_dot(wiring, "x")))


def test_blocks_are_drawn_in_the_order_of_the_data():
    dot = wiring_dot(read_wiring(outer()), "x")
    assert dot.index('"inner.gain" [') < dot.index('"inner.adder" [')
    assert dot.index('"source" [') < dot.index('"a_sink" [')


def test_drawing_is_the_same_every_time_and_holds_no_address(walk_dot):
    assert picture_of("walk").dot == walk_dot
    assert "0x" not in walk_dot
    assert draw.render_svg(walk_dot) == draw.render_svg(walk_dot)


def test_loops_do_not_push_blocks_down(walk_dot):
    back = {line.split(" [")[0].strip() for line in walk_dot.splitlines() if "constraint" in line}
    assert {edge.split(":")[0] for edge in back} == {'"plant"', '"scene_graph"'}
    assert sum("controller.state in" in edge for edge in back) == 1


@pytest.mark.parametrize("name", DRAWN)
def test_a_drawing_can_be_read_on_a_page(name):
    """Text has 9 pixels or more where it is shown 900 wide, as the drawings of a page are."""
    svg = ET.fromstring((diagrams_dir() / f"{name}.svg").read_text(encoding="utf-8"))
    scale = min(1.0, 900.0 / float(svg.get("viewBox").split()[2]))
    sizes = [float(node.get("font-size")) for node in svg.iter(f"{SVG}text")]
    assert scale * min(sizes) > 9.0


def test_edges_have_the_colour_of_the_block_that_makes_the_signal(walk_dot):
    red = COLOURS["wbc"][0]
    (line,) = [x for x in walk_dot.splitlines() if '-> "plant"' in x and "controller.torque" in x]
    assert f'color="{red}"' in line


def test_svg_shows_every_port_and_block(walk, walk_dot):
    shown = texts(draw.render_svg(walk_dot))
    ports = [port for pair in walk.connections for port in pair]
    assert {port.name for port in ports} <= set(shown)
    names = {part for port in ports for part in port.system.split(".")}
    assert names <= set(shown)
    assert shown.count("state") == 3  # of the plant, the controller and its dynamics
    assert shown.count("dynamics") == 8  # of what makes it, exports it, reads it


def test_odd_names_are_drawn_as_they_are():
    builder = DiagramBuilder()
    builder.AddNamedSystem('a "b" <c> & d', Gain(1.0, 1))
    dot = wiring_dot(read_wiring(builder.Build()), 'title "x" <y>')
    assert {'a "b" <c> & d', 'title "x" <y>'} <= set(texts(draw.render_svg(dot)))


def test_controller_alone_is_drawn_too():
    scenario = load_scenario("walk")
    diagram = build_controller(load_humanoid(scenario.robot), scenario)
    text = draw.wiring_text(read_wiring(diagram))
    assert "state_dynamics.dynamics -> ecd_mpc.dynamics\n" in text
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
    files = draw.draw(picture_of("stand"), tmp_path / "new", png=True)
    assert [file.name for file in files] == ["stand.txt", "stand.dot"]
    assert files[1].read_text(encoding="utf-8").startswith("digraph wiring {")


def test_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=r"walk\.txt: cannot be written"):
        draw.draw(picture_of("walk"), tmp_path / "file")


def test_every_scenario_is_drawn():
    assert list(scenario_files()) == DRAWN


@pytest.mark.parametrize("name", DRAWN)
def test_committed_drawing_is_up_to_date(name):
    """When this fails, run `linefoot draw NAME` and commit what it writes."""
    picture = picture_of(name)
    text = (diagrams_dir() / f"{name}.txt").read_text(encoding="utf-8")
    assert text == draw.wiring_text(picture.wiring)
    svg = (diagrams_dir() / f"{name}.svg").read_text(encoding="utf-8")
    (fingerprint,) = re.findall(r"^<!-- .* wiring (\w+) -->$", svg, flags=re.M)
    assert fingerprint == draw.fingerprint(picture.dot)
    assert sorted(texts(svg)) == sorted(texts(draw.render_svg(picture.dot)))


def test_rates_are_on_the_edges(walk_dot, walk):
    edges = [line for line in walk_dot.splitlines() if " -> " in line]
    assert len(edges) == len(walk.connections)
    assert all(re.search(r'label="(1 kHz|50 Hz|per segment|when asked)"', e) for e in edges)
    (plan,) = [e for e in edges if '"controller.ecd_mpc":o0:s -> "controller.whole' in e]
    assert 'label="50 Hz"' in plan


def test_rates_are_those_of_the_scenario(tmp_path):
    (tmp_path / "slow.yaml").write_text("plant: {time_step: 0.002}\nmpc: {period: 0.04}\n")
    shown = set(re.findall(r'label="([^"]*Hz)"', picture_of(str(tmp_path / "slow.yaml")).dot))
    assert shown == {"500 Hz", "25 Hz"}


def test_controller_is_drawn_with_its_outputs_at_the_bottom():
    svg = ET.fromstring(draw.render_svg(picture_of("controller").dot))
    at = {node.text: float(node.get("y")) for node in svg.iter(f"{SVG}text")}
    assert at["command"] < at["horizon"] < at["torque"]
    assert "constraint=false" not in picture_of("controller").dot


@pytest.mark.parametrize("name", ["ecd_mpc", "controller.ecd_mpc"])
def test_a_block_alone_shows_what_its_ports_carry(name, tmp_path):
    picture = picture_of(name)
    files = draw.draw(picture, tmp_path, png=True)
    assert [file.name for file in files] == ["ecd_mpc.svg", "ecd_mpc.png"]
    shown = texts(files[0].read_text(encoding="utf-8"))
    assert {"ecd_mpc", "dynamics", "reference", "plan"} <= set(shown)
    assert "RobotDynamics · 17 parts = 1148 · by part · W, joints · 50 Hz" in shown
    assert files[1].read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("system", ["plant", "scene_graph", "recorder", "command"])
def test_every_system_can_be_drawn_alone(system, tmp_path):
    assert draw.draw(picture_of(system), tmp_path)[-1].stat().st_size > 500


def test_a_system_of_ones_own_is_drawn(tmp_path):
    files = draw.draw(picture_of_system(outer()), tmp_path)
    assert [file.suffix for file in files] == [".txt", ".svg"]
    gain = Gain(1.0, 3)
    gain.set_name("my_gain")
    shown = texts(draw.draw(picture_of_system(gain), tmp_path)[0].read_text(encoding="utf-8"))
    assert {"my_gain", "u0", "y0", "vector · 3"} <= set(shown)


def test_what_is_not_there_is_refused():
    with pytest.raises(InputError, match=r"draw = 'nothing': no such .* 'walk', .*ecd_mpc"):
        picture_of("nothing")
