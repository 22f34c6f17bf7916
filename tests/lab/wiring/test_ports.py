"""What goes through the ports: one table, and everything else that says so agrees with it."""

import inspect
import re

import numpy as np
import pytest
import yaml
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, PortDataType
from pydrake.systems.primitives import ConstantVectorSource, Gain, LogVectorOutput

from drake_linefoot import signals
from drake_linefoot.lab.plants.contact_forces import contacts_layout
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.lab.wiring.draw import picture_of, picture_of_system
from drake_linefoot.lab.wiring.graph import all_blocks, read_wiring
from drake_linefoot.lab.wiring.ports import OWN, PLAN, SEGMENTS, SIGNALS, TICK, rate_in_words
from drake_linefoot.resources import diagrams_dir
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.terrain import TERRAIN
from drake_linefoot.wiring.controller import build_controller
from tests.helpers.recorded_runs import short_run

SIZES = {"nq + nv": 49, "na": 18, "2 na + 12": 48, "4": 4, "3": 3}
SIZES |= {"na + 12": 30, "6": 6, "27 x 27": 729}
MIT = load_humanoid("mit_humanoid")
LAYOUTS = {
    layout.signal.__name__: layout
    for layout in (*signals.layouts(MIT.sizes).values(), contacts_layout(MIT), TERRAIN)
}
VECTORS = {"vector", *LAYOUTS}


@pytest.fixture(scope="module")
def systems():
    """Our own blocks of the closed loop, by path; with everything that can be in it."""
    entries = {"sensors.gyro": 0.1, "actuators.delay": 0.002, "mpc.late": True}
    loop = build_closed_loop(load_scenario("walk", entries), pushes=True)
    estimating = build_closed_loop(load_scenario("walk", {"estimation": True}))
    both = (read_wiring(each) for each in (estimating, loop))
    blocks = [block for wiring in both for block in all_blocks(wiring)]
    return {b.path: b.system for b in blocks if b.kind.__module__.startswith("drake_linefoot.")}


def signal_of(system, name):
    return OWN.get((type(system).__name__, name)) or SIGNALS[name]


def ports_of(system):
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    return inputs + [system.get_output_port(i) for i in range(system.num_output_ports())]


def test_committed_tables_are_up_to_date():
    """When this fails, run `linefoot draw walk --ports > diagrams/ports.md` and commit it."""
    text = (diagrams_dir() / "ports.md").read_text(encoding="utf-8")
    assert text == picture_of("walk").ports


def test_tables_have_every_port_of_the_walk_and_no_other():
    picture = picture_of("walk")
    written = set()
    for section in picture.ports.split("\n## ")[1:]:  # of blocks, and of signals without ways
        system = section.split("\n", 1)[0].strip()
        for name, way in re.findall(r"^\| `(\w+)` +\| (in|out) ", section, flags=re.M):
            written.add((system, name, way == "in"))
    pairs = picture.wiring.connections
    assert written == {(p.system, p.name, p.is_input) for pair in pairs for p in pair}


def test_every_port_of_ours_is_known_and_has_the_type_and_size_it_should(systems):
    assert len(systems) >= 10
    for path, system in systems.items():
        for port in ports_of(system):
            name = port.get_name()
            signal = signal_of(system, name)
            if port.get_data_type() != PortDataType.kVectorValued:
                assert signal.type not in VECTORS, (path, name)
            elif signal.type == "vector":
                assert port.size() == SIZES[signal.shape], (path, name)
            else:
                assert port.size() == LAYOUTS[signal.type].size, (path, name)


def test_no_port_of_the_controller_is_abstract(systems):
    """So that Drake's own loggers, holds and plots take what is on them."""
    controllers = [path for path in systems if path.startswith("controller.")]
    assert len(controllers) >= 6
    for path in controllers:
        for port in ports_of(systems[path]):
            assert port.get_data_type() == PortDataType.kVectorValued, (path, port.get_name())


def test_drakes_logger_takes_every_output_of_the_controller(humanoid):
    builder = DiagramBuilder()
    controller = builder.AddSystem(build_controller(humanoid, Scenario()))
    outputs = [controller.get_output_port(i) for i in range(controller.num_output_ports())]
    logs = {port.get_name(): LogVectorOutput(port, builder, 0.001) for port in outputs}
    values = {"state": humanoid.x_nominal, "command": np.zeros(4), "applied_torque": np.zeros(18)}
    for name, value in values.items():
        source = builder.AddSystem(ConstantVectorSource(value))
        builder.Connect(source.get_output_port(), controller.GetInputPort(name))
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.0045)
    root = simulator.get_context()
    for name, log in logs.items():
        data = log.FindLog(root).data()
        assert data.shape[1] == 5, name
        assert np.isfinite(data).all(), name
    where = LAYOUTS["RobotDynamics"].place("p_WG")
    height = logs["dynamics"].FindLog(root).data()[where][2]
    assert height == pytest.approx(humanoid.com_height, abs=1e-9)


def test_docstrings_of_the_blocks_agree(systems):
    """With the names of their ports, in the form that Drake's own documentation has."""
    for path, system in systems.items():
        text = inspect.getdoc(type(system))
        said = yaml.safe_load(re.search(r"\.\. pydrake_system::\n\n((?:    .*\n)+)", text)[1])
        assert said["name"] == type(system).__name__
        ways = (system.num_input_ports, system.get_input_port, "input_ports"), (
            system.num_output_ports, system.get_output_port, "output_ports",
        )  # fmt: skip
        for count, get, name in ways:
            assert said.get(name, []) == [get(i).get_name() for i in range(count())], path


def test_every_part_of_a_signal_is_in_the_tables():
    text = picture_of("walk").ports
    kinds = [kind for name, kind in signals.SIGNALS.items() if name != "estimate"]
    for kind in kinds:
        section = text.split(f"\n## {kind.__name__}\n")[1].split("\n## ")[0]
        assert re.findall(r"^\| `(\w+)`", section, flags=re.M) == list(kind._fields)


def test_rates_are_those_of_a_run():
    run = short_run()
    s = run.scenario
    np.testing.assert_allclose(np.diff(run.time), s.plant.time_step)
    plans = run.time[~np.isnan(run.mpc_ms)]
    np.testing.assert_allclose(np.diff(plans), s.mpc.period)
    words = [rate_in_words(rate, s) for rate in (TICK, PLAN, SEGMENTS)]
    assert words == ["1 kHz", "50 Hz", "per segment"]


def test_a_rate_that_is_not_round_is_said_shortly():
    scenario = Scenario()
    scenario.plant.time_step, scenario.mpc.period = 0.003, 0.03
    assert [rate_in_words(rate, scenario) for rate in (TICK, PLAN)] == ["333.3 Hz", "33.33 Hz"]


def test_ports_of_a_diagram_and_of_a_block_alone():
    controller = picture_of("controller").ports
    assert controller.startswith("# Ports of controller\n")
    assert "| `torque` " in controller and "## ecd_mpc" in controller
    alone = picture_of("gait_planner").ports
    assert alone.split("\n## GaitTargets\n")[0].count("| in ") == 4
    assert alone.count("| out ") == 2


def test_ports_of_a_foreign_block_say_what_they_can():
    gain = Gain(1.0, 3)
    gain.set_name("state")
    table = picture_of_system(gain).ports
    assert re.search(r"\| `u0` \| in  \| vector \| 3 +\| - ", table)


def test_blocks_inside_blocks_are_listed():
    names = re.findall(r"^## (.+)$", picture_of("walk").ports, flags=re.M)
    assert names[:4] == ["command", "command.schedule", "contact_forces", "controller"]
    assert "controller.ecd_mpc" in names
