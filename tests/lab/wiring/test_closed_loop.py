from dataclasses import replace

import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from drake_linefoot.errors import InputError
from drake_linefoot.lab.plants.initial_state import initial_state
from drake_linefoot.lab.scenario import Perturbation, Scenario, Segment
from drake_linefoot.lab.scenario.schema import PlantParameters
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.layout import flat
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.signals import SIGNALS
from drake_linefoot.wiring.controller import EXPORTS, check_plant
from tests.helpers.recorded_runs import SHORT, Limp


def names(loop):
    return [system.get_name() for system in loop.GetSystems()]


def test_every_system_has_a_name_that_says_what_it_is():
    loop = build_closed_loop(SHORT)
    assert loop.get_name() == "closed_loop"
    assert names(loop) == [
        "plant",
        "scene_graph",
        "controller",
        "command",
        "contact_forces",
        "recorder",
    ]


def test_ten_lines_of_drake_simulate_it():
    loop = build_closed_loop(SHORT)
    simulator = loop.make_simulator()
    simulator.AdvanceTo(0.02)
    q = loop.plant.state(simulator.get_context())
    assert q[6] == pytest.approx(loop.humanoid.q_nominal[6], abs=0.01)


@pytest.mark.parametrize("knots", [5, 20])
def test_with_another_number_of_knots_all_that_holds_plans_is_as_large(knots):
    mpc = MpcParameters(knots=knots, late=True)
    loop = build_closed_loop(replace(SHORT, mpc=mpc))
    simulator = loop.make_simulator()
    simulator.AdvanceTo(0.15)
    root = simulator.get_context()
    assert loop.look("plan", root).wrench.shape == (knots, 2, 5)
    assert loop.look("reference", root).times.shape == (knots + 1,)
    recorder = loop.recorder
    assert (recorder.samples("mpc_success") == 1.0).all()
    assert np.isfinite(recorder.samples("mpc_horizon")).all()


def test_signals_of_the_controller_are_looked_at_by_their_parts():
    loop = build_closed_loop(SHORT)
    simulator = loop.make_simulator()
    simulator.AdvanceTo(0.02)
    root = simulator.get_context()
    controller, context = loop.controller, loop.controller.GetMyContextFromRoot(root)
    for name in EXPORTS:
        signal, vector = loop.look(name, root), controller.GetOutputPort(name).Eval(context)
        assert type(signal) is SIGNALS.get(name, np.ndarray)
        np.testing.assert_array_equal(flat(signal) if name in SIGNALS else signal, vector)
    x = loop.plant.state(root)
    np.testing.assert_array_equal(loop.look("dynamics", root).q, x[: loop.humanoid.nq])


def test_the_simulator_starts_in_the_perturbed_state_at_time_0():
    scenario = Scenario(seed=3, perturbation=Perturbation(0.01, 0.1, 0.05))
    loop = build_closed_loop(scenario)
    context = loop.make_simulator().get_context()
    assert context.get_time() == 0.0
    x = loop.plant.state(context)
    np.testing.assert_array_equal(x, initial_state(loop.humanoid, scenario))
    assert (x != loop.humanoid.x_nominal).any()


def test_it_is_a_diagram_whose_default_context_is_where_a_run_begins():
    loop = build_closed_loop(Scenario(seed=3, perturbation=Perturbation(joint_position=0.02)))
    assert isinstance(loop, Diagram)
    begin = initial_state(loop.humanoid, loop.scenario)
    np.testing.assert_array_equal(loop.plant.state(loop.CreateDefaultContext()), begin)
    plain, made = Simulator(loop), loop.make_simulator()
    for simulator in (plain, made):
        simulator.AdvanceTo(0.05)
    after = [loop.plant.state(simulator.get_context()) for simulator in (plain, made)]
    np.testing.assert_array_equal(*after)


def test_mujoco_begins_there_too_with_its_velocities():
    plant = PlantParameters(simulator="mujoco")
    loop = build_closed_loop(
        Scenario(seed=3, plant=plant, perturbation=Perturbation(0.02, 0.1, 0.05))
    )
    begin = initial_state(loop.humanoid, loop.scenario)
    np.testing.assert_array_equal(loop.plant.state(loop.CreateDefaultContext()), begin)


def test_the_plant_is_what_the_controller_counts_on():
    scenario = Scenario()
    scenario.plant.time_step = 0.002
    plant = build_closed_loop(scenario).plant.system
    assert plant.time_step() == 0.002
    assert plant.has_sampled_output_ports()
    assert plant.get_contact_model().name == "kPoint"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"use_sampled_output_ports": False}, "use_sampled_output_ports = False: must be sampled"),
        ({"time_step": 0.0}, r"time_step = 0.0: must be 0.001 s"),
        ({"time_step": 0.002}, r"time_step = 0.002: must be 0.001 s"),
    ],
)
def test_a_plant_that_shows_the_torque_of_another_time_is_refused(changes, message):
    config = MultibodyPlantConfig(**({"time_step": 0.001} | changes))
    plant, _ = AddMultibodyPlant(config, DiagramBuilder())
    with pytest.raises(InputError, match=message):
        check_plant(plant, 0.001)


def test_an_own_controller_is_put_in():
    controller = Limp(torque=1.5)
    loop = build_closed_loop(SHORT, controller=controller)
    assert loop.controller is controller
    assert "limp" in names(loop)
    simulator = loop.make_simulator()
    simulator.Initialize()
    simulator.AdvanceTo(0.01)
    np.testing.assert_array_equal(loop.recorder.samples("applied_torque")[-1], np.full(18, 1.5))


class OneInput(LeafSystem):
    """A controller that looks at the state only, with or without a torque."""

    def __init__(self, torque):
        super().__init__()
        self.set_name("one_input")
        self.DeclareVectorInputPort("state", 49)
        if torque:
            zero = np.zeros(18)
            self.DeclareVectorOutputPort("torque", 18, lambda _, output: output.SetFromVector(zero))


def test_a_controller_needs_a_torque_and_no_more():
    build_closed_loop(SHORT, controller=OneInput(torque=True)).make_simulator().AdvanceTo(0.01)
    with pytest.raises(InputError, match="'one_input': lacks the output port torque"):
        build_closed_loop(SHORT, controller=OneInput(torque=False))


@pytest.mark.parametrize("field", ["robot", "scene"])
def test_an_unknown_robot_or_scene_is_refused(field):
    with pytest.raises(InputError, match=rf"{field} = 'none': unknown {field}; must be one of"):
        build_closed_loop(Scenario(**{field: "none"}))


def test_with_meshcat_robot_forces_and_overlays_are_drawn():
    meshcat = Meshcat(MeshcatParams(port=0))
    scenario = Scenario(segments=[Segment("stand", 0.1)])
    loop = build_closed_loop(scenario, meshcat)
    assert {"meshcat_visualizer(visualizer)", "overlays"} <= set(names(loop))
    loop.make_simulator().AdvanceTo(0.05)
    for path in (
        "/drake/visualizer/mit_humanoid/torso",
        "/overlays/true contact force/left heel",
        "/overlays/footholds/left/0",
        "/overlays/centre of mass/now",
        "/ground_lines",
    ):
        assert meshcat.HasPath(path), path


def test_with_meshcat_and_an_own_controller_the_rest_is_drawn():
    meshcat = Meshcat(MeshcatParams(port=0))
    loop = build_closed_loop(SHORT, meshcat, Limp())
    loop.make_simulator().AdvanceTo(0.05)
    assert meshcat.HasPath("/overlays/centre of mass/now")
    assert not meshcat.HasPath("/overlays/footholds")
