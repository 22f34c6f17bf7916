"""Drawings say what is connected to what, and the committed ones are up to date."""

import re
import sys
import xml.etree.ElementTree as ET

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, Gain, PassThrough

from drake_linefoot.errors import InputError, OutputError
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.wiring import draw
from drake_linefoot.lab.wiring.draw import COLOURS, picture_of, picture_of_system
from drake_linefoot.lab.wiring.graph import read_wiring
from drake_linefoot.resources import diagrams_dir, scenario_files
from drake_linefoot.robot.humanoid import load_humanoid
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
    picture = picture_of_system(builder.Build())
    assert draw.wiring_text(picture.wiring) == ""
    assert [(b.name, b.inputs, b.outputs) for b in picture.wiring.blocks] == [("alone", (), ())]
    assert "alone" in texts(draw.render_svg(picture.dot))


def test_a_diagram_inside_is_one_block():
    shown = texts(draw.render_svg(picture_of_system(outer()).dot))
    assert {"inner", "source", "a_sink"} <= set(shown)
    assert not {"gain", "adder"} & set(shown)
    assert {"gain", "adder", "value"} <= set(texts(draw.render_svg(picture_of_system(inner()).dot)))


def test_drawing_is_the_same_every_time_and_holds_no_address(walk_dot):
    assert picture_of("walk").dot == walk_dot
    assert "0x" not in walk_dot
    assert draw.render_svg(walk_dot) == draw.render_svg(walk_dot)


@pytest.mark.parametrize("name", DRAWN)
def test_a_drawing_can_be_read_on_a_page(name):
    """Text has 9 pixels or more where it is shown 900 wide, as the drawings of a page are."""
    svg = ET.fromstring((diagrams_dir() / f"{name}.svg").read_text(encoding="utf-8"))
    scale = min(1.0, 900.0 / float(svg.get("viewBox").split()[2]))
    sizes = [float(node.get("font-size")) for node in svg.iter(f"{SVG}text")]
    assert scale * min(sizes) > 9.0


def edges(picture):
    return [line for line in picture.dot.splitlines() if " -> " in line]


def test_edges_have_the_colour_of_the_block_that_makes_the_signal():
    red, found = COLOURS["wbc"][0], edges(picture_of("controller"))
    (line,) = [x for x in found if x.startswith('"whole_body_controller" -> ') and "torque" in x]
    assert f'color="{red}"' in line


@pytest.mark.parametrize("name", ["walk", "controller"])
def test_a_drawing_has_every_block_and_all_that_goes_between_them(name):
    picture = picture_of(name)
    svg = ET.fromstring(draw.render_svg(picture.dot))
    between = {
        (source.system, target.system)
        for source, target in picture.wiring.connections
        if "." not in source.system + target.system and source.system and target.system
    }
    drawn = [node.find(f"{SVG}title").text for node in svg.iter(f"{SVG}g") if len(node) > 1]
    pairs = [title.split("->") for title in drawn if "->" in title]
    makes = {signal: block for block, signal in pairs if "." not in block}
    assert {(makes[s], reader) for s, reader in pairs if makes.get(s)} == between
    names = {block.name for block in picture.wiring.blocks}
    assert names <= set(texts(draw.render_svg(picture.dot)))


def test_a_port_of_another_name_is_named_on_the_line(walk_dot):
    (line,) = [x for x in walk_dot.splitlines() if x.startswith('"controller.torque" -> "plant"')]
    assert 'label="actuation"' in line


def test_odd_names_are_drawn_as_they_are():
    builder = DiagramBuilder()
    builder.AddNamedSystem('a "b" <c> & d', Gain(1.0, 1))
    diagram = builder.Build()
    diagram.set_name('title "x" <y>')
    dot = picture_of_system(diagram).dot
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


def test_every_scenario_and_the_controller_are_drawn():
    assert sorted([*scenario_files(), "controller"]) == DRAWN


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


def test_type_size_and_rate_of_each_signal_are_drawn():
    shown = texts(draw.render_svg(picture_of("controller").dot))
    assert shown[shown.index("plan") + 1 :][:2] == ["CentroidalPlan 831", "50 Hz"]
    assert shown[shown.index("torque") + 1 :][:2] == ["vector 18", "1 kHz"]


def test_rates_are_those_of_the_scenario(tmp_path):
    (tmp_path / "slow.yaml").write_text("plant: {time_step: 0.002}\nmpc: {period: 0.04}\n")
    shown = texts(draw.render_svg(picture_of(str(tmp_path / "slow.yaml")).dot))
    assert {text for text in shown if text.endswith("Hz")} == {"500 Hz", "25 Hz"}


def test_controller_is_drawn_with_its_outputs_at_the_bottom():
    svg = ET.fromstring(draw.render_svg(picture_of("controller").dot))
    at = {node.text: float(node.get("y")) for node in svg.iter(f"{SVG}text")}
    assert at["command"] < at["horizon"] < at["torque"]


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
