"""The controller as plain arrays: the torques of the closed loop, to the bit."""

import numpy as np
import pytest

from drake_linefoot.errors import InputError, LinefootError, SignalError
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.load import make_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.terrain import felt_ground
from drake_linefoot.wiring.without_simulator import STAND, Controller

SEGMENTS = [
    Segment("stand", 0.1),
    Segment("walk", 1.0, True, [0.5, 0.05], 0.3),
    Segment("stop", 0.4),
]
VARIANTS = {
    "as it is": {},
    "late": {"mpc": {"late": True, "model": "srbm", "solver": "active_set"}},
    "process": {"mpc": {"process": True}},
    "2 ms": {"plant": {"time_step": 0.002}},
    "constrained": {"estimator": {"method": "constrained"}},
    "stairs": {
        "ground": {"stairs": {"rise": 0.1, "steps": 2, "at": 0.25}},
        "terrain": {"source": "scene", "known": [[0.0, 1.2]]},
    },
}


def walked(scenario):
    """The loop of a run, and state, applied torque, command, map and torque of every tick."""
    loop, rows = build_closed_loop(scenario), []

    def look(root):
        if root.get_time() != round(root.get_time() / scenario.period) * scenario.period:
            return  # a plan that came a rounding beside a tick
        own = loop.controller.GetMyContextFromRoot(root)
        names = "state", "applied_torque", "command", "terrain"
        ports = [loop.controller.GetInputPort(name) for name in names]
        values = [port.Eval(own) if port.HasValue(own) else None for port in ports]
        rows.append((*values, loop.controller.GetOutputPort("torque").Eval(own)))

    simulate(loop, look=look)
    return loop, rows


@pytest.fixture(scope="module", params=VARIANTS)
def ticks(request):
    """A walk in a closed loop: robot, scenario and rows of its ticks."""
    plain = {"segments": [vars(segment) for segment in SEGMENTS], **VARIANTS[request.param]}
    loop, rows = walked(make_scenario(plain))
    return loop.humanoid, loop.scenario, rows


def follow(controller, rows, begin=0):
    """Tick along a walk; return the torques after tick `begin`."""
    return np.array(
        [
            controller.tick(state, applied, *before[2:4])
            for before, (state, applied, *_) in zip(rows[begin:-1], rows[begin + 1 :], strict=True)
        ]
    )


def test_torques_are_those_of_the_closed_loop(ticks):
    humanoid, scenario, rows = ticks
    assert len(rows) == round(1.5 / scenario.period) + 1
    controller = Controller(humanoid, scenario)
    torques = [controller.begin(rows[0][0], rows[0][3]), *follow(controller, rows)]
    np.testing.assert_array_equal(torques, [row[4] for row in rows])
    again = [controller.begin(rows[0][0], rows[0][3]), *follow(controller, rows[:50])]
    np.testing.assert_array_equal(again, [row[4] for row in rows[:50]])
    if scenario.terrain.source == "scene":
        controller.begin(rows[0][0])
        felt = follow(controller, [(*row[:3], None) for row in rows])
        assert not np.array_equal(felt, torques[1:])


def test_what_was_saved_goes_on_in_another_controller(ticks):
    humanoid, scenario, rows = ticks
    one, other = (Controller(humanoid, scenario) for _ in range(2))
    one.begin(rows[0][0], rows[0][3])
    follow(one, rows[:311])
    saved = one.save()
    assert saved.dtype == float and saved.ndim == 1
    other.restore(saved)
    np.testing.assert_array_equal(other.save(), saved)
    np.testing.assert_array_equal(follow(other, rows[:500], 310), [row[4] for row in rows[311:500]])
    one.restore(saved)
    np.testing.assert_array_equal(follow(one, rows[:400], 310), [row[4] for row in rows[311:400]])


@pytest.fixture
def standing(humanoid):
    controller = Controller(humanoid)
    controller.begin(humanoid.x_nominal)
    return controller


def with_number(array, at, number):
    changed = np.array(array)
    changed[at] = number
    return changed


def test_what_cannot_be_used_is_refused_and_changes_nothing(humanoid, standing):
    x, torque = humanoid.x_nominal, np.zeros(humanoid.na)
    before = standing.save()
    for values, words in (
        ((with_number(x, 3, np.nan), torque, STAND), r"controller\.state: element 3 is nan"),
        ((x, with_number(torque, 2, np.inf), STAND), r"applied_torque: element 2 is inf"),
        ((x, torque, with_number(STAND, 0, np.nan)), r"controller\.command: element 0 is nan"),
        ((x[:-1], torque, STAND), r"controller\.state: has shape \(48,\): must be \(49,\)"),
        ((x, torque, STAND[:3]), r"controller\.command: has shape \(3,\): must be \(4,\)"),
        ((x, torque, STAND, [1.0]), r"controller\.terrain: has shape \(1,\): must be \(\d+,\)"),
        ((x, torque, STAND, with_number(felt_ground(), 0, np.nan)), r"terrain: element 0 is nan"),
    ):
        with pytest.raises(SignalError, match=words):
            standing.tick(*values)
        np.testing.assert_array_equal(standing.save(), before)
    with pytest.raises(SignalError, match=r"controller\.saved: has shape"):
        standing.restore(before[:-1])
    assert np.isfinite(standing.tick(x, torque, STAND)).all()


def test_signals_can_be_looked_at(humanoid, standing):
    standing.tick(humanoid.x_nominal, np.zeros(humanoid.na), STAND)
    np.testing.assert_array_equal(standing.look("contact").contact, [1.0, 1.0])
    assert standing.look("torque").shape == (humanoid.na,)
    assert standing.look("plan").wrench.shape[1:] == (2, 5)


def test_warming_up_leaves_it_where_it_was(humanoid, standing, monkeypatch):
    monkeypatch.setattr(
        "drake_linefoot.wiring.without_simulator.compile_first", lambda walk: walk()
    )
    before = standing.save()
    standing.warm_up()
    np.testing.assert_array_equal(standing.save(), before)


def test_a_block_that_lacks_a_port_is_refused(humanoid):
    from pydrake.systems.framework import LeafSystem

    from drake_linefoot.wiring.controller import build_controller

    with pytest.raises(InputError):
        Controller(humanoid, diagram=build_controller(humanoid, mpc=LeafSystem()))
    assert issubclass(SignalError, LinefootError)


def test_parameters_of_a_scenario_are_in_the_size_of_the_robot(small_biped):
    scenario = Scenario()
    by_scenario, by_default = Controller(small_biped, scenario), Controller(small_biped)
    first = [c.begin(small_biped.x_nominal) for c in (by_scenario, by_default)]
    np.testing.assert_array_equal(first[0], first[1])
    assert scaled(scenario, small_biped).gait.com_height != scenario.gait.com_height
