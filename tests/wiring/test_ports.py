"""What goes through the ports: one table, and everything else that says so agrees with it."""

import inspect
import re

import numpy as np
import pytest
from pydrake.systems.framework import PortDataType
from pydrake.systems.primitives import Gain

from drake_linefoot.resources import diagrams_dir
from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.scenario import Scenario
from drake_linefoot.scenario.load import load_scenario
from drake_linefoot.wiring.closed_loop import build_closed_loop
from drake_linefoot.wiring.draw import picture_of, picture_of_system
from drake_linefoot.wiring.graph import all_blocks, read_wiring
from drake_linefoot.wiring.ports import OWN, PLAN, SEGMENTS, SIGNALS, TICK, rate_in_words
from tests.helpers.recorded_runs import short_run

SIZES = {"nq + nv": 49, "na": 18, "2 na + 12": 48, "4": 4, "3": 3}
SIZES |= {"na + 12": 30, "6": 6, "27 x 27": 729}


@pytest.fixture(scope="module")
def systems():
    """Our own blocks of the closed loop, by path; with everything that can be in it."""
    entries = {"sensors.gyro": 0.1, "actuators.delay": 0.002, "mpc.late": True}
    loop = build_closed_loop(load_scenario("walk", entries), pushes=True)
    estimating = build_closed_loop(load_scenario("walk", {"estimation": True}))
    both = (read_wiring(each.diagram) for each in (estimating, loop))
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
    for section in picture.ports.split("\n## ")[1:]:
        system = section.split("\n", 1)[0].strip()
        for name, way in re.findall(r"^\| `(\w+)` +\| (in|out) ", section, flags=re.M):
            written.add((system, name, way == "in"))
    pairs = picture.wiring.connections
    assert written == {(p.system, p.name, p.is_input) for pair in pairs for p in pair}


def test_every_port_of_ours_is_known_and_has_the_type_and_size_it_should(systems):
    assert len(systems) >= 10
    for path, system in systems.items():
        for port in ports_of(system):
            signal = signal_of(system, port.get_name())
            is_vector = port.get_data_type() == PortDataType.kVectorValued
            assert is_vector == (signal.type == "vector"), (path, port.get_name())
            if is_vector:
                assert port.size() == SIZES[signal.shape], (path, port.get_name())


def test_docstrings_of_the_blocks_agree(systems):
    """Names, types, and the shapes of vectors; what else they say is theirs."""
    for path, system in systems.items():
        text = inspect.getdoc(type(system))
        rows = re.findall(r"^\| (\w+) \| ([^|]+) \| ([^|]+) \|", text, flags=re.M)[1:]
        assert [row[0] for row in rows] == [p.get_name() for p in ports_of(system)], path
        for name, kind, shape in rows:
            signal = signal_of(system, name)
            assert kind == signal.type, (path, name)
            if kind == "vector":
                assert shape == signal.shape, (path, name)


def test_signals_are_classes_of_the_package():
    from drake_linefoot import signals
    from drake_linefoot.gait.horizon import GaitHorizon

    known = {*dir(signals), GaitHorizon.__name__, RobotDynamics.__name__}
    for name in (
        "dynamics",
        "contact",
        "targets",
        "horizon",
        "reference",
        "plan",
        "report",
        "estimate",
    ):
        assert SIGNALS[name].type in known


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
    assert alone.count("\n| `") == 5


def test_ports_of_a_foreign_block_say_what_they_can():
    gain = Gain(1.0, 3)
    gain.set_name("state")
    table = picture_of_system(gain).ports
    assert re.search(r"\| `u0` \| in  \| vector \| 3 +\| - ", table)


def test_blocks_inside_blocks_are_listed():
    names = re.findall(r"^## (.+)$", picture_of("walk").ports, flags=re.M)
    assert names[:2] == ["command", "command.schedule"]
    assert "controller.ecd_mpc" in names and names.index("controller") == 2
