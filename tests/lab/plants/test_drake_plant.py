"""A plant alone: the ports that a closed loop is wired to, and what they say of a robot at rest."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.lab.plants.contact_forces import FootContacts
from drake_linefoot.lab.plants.drake import DrakePlant, TorsoForce
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.layout import Layout
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.robot.state_dynamics import StateDynamics
from drake_linefoot.wiring.controller import connect_by_name


@pytest.fixture
def sinking(humanoid):
    """A plant whose robot has no torque, 20 ms after it stood: it sinks down."""
    builder = DiagramBuilder()
    plant = DrakePlant(builder, humanoid, scaled(Scenario(), humanoid), drawn=False)
    dynamics = builder.AddSystem(StateDynamics(humanoid))
    connect_by_name(builder, dynamics, plant.outputs)
    sources = {"dynamics": dynamics.GetOutputPort("dynamics")}
    ports = {**plant.outputs, **plant.add_imu(builder)}
    ports["foot_contacts"] = plant.add_contacts(builder, sources)
    for name, port in ports.items():
        builder.ExportOutput(port, name)
    builder.ExportInput(plant.actuation, "actuation")
    simulator = Simulator(diagram := builder.Build())
    context = simulator.get_mutable_context()
    diagram.GetInputPort("actuation").FixValue(context, np.zeros(humanoid.na))
    plant.place(context, humanoid.x_nominal)
    simulator.AdvanceTo(0.02)
    return plant, {name: diagram.GetOutputPort(name).Eval(context) for name in ports}


def test_its_ports_have_the_sizes_of_the_robot(humanoid, sinking):
    plant, values = sinking
    sizes = {name: len(value) for name, value in values.items()}
    assert sizes == {
        "state": humanoid.nq + humanoid.nv,
        "net_actuation": humanoid.na,
        "angular_velocity": 3,
        "specific_force": 3,
        "foot_contacts": Layout(FootContacts, {"nc": 2}).size,
    }
    assert plant.actuation.size() == humanoid.na
    assert plant.ground.height(0.3, 0.1) == 0.0


def test_what_it_says_of_a_robot_that_sinks_down_fits_together(humanoid, sinking):
    """Without torque the feet still bear; the IMU feels what the base does not fall."""
    _, values = sinking
    contacts = Layout(FootContacts, {"nc": 2}).open(values["foot_contacts"])
    borne = contacts.force[:, 2].sum()
    assert 0.1 < borne / (9.81 * humanoid.mass) < 1.5
    np.testing.assert_allclose(contacts.normal.sum(), borne, rtol=1e-9)
    np.testing.assert_array_equal(values["net_actuation"], 0.0)
    q = values["state"][: humanoid.nq]
    np.testing.assert_allclose(
        values["angular_velocity"], values["state"][humanoid.nq :][:3], atol=0.05
    )
    assert np.linalg.norm(q[:4]) == pytest.approx(1.0)
    assert np.linalg.norm(values["specific_force"]) < 2.0 * 9.81


def test_a_push_acts_on_the_torso_at_its_centre_of_mass(humanoid):
    force = TorsoForce(humanoid.torso)
    context = force.CreateDefaultContext()
    force.GetInputPort("push").FixValue(context, [1.0, 2.0, 3.0])
    (applied,) = force.GetOutputPort("force").Eval(context)
    assert applied.body_index == humanoid.plant.GetBodyByName("torso").index()
    np.testing.assert_array_equal(applied.p_BoBq_B, humanoid.torso.default_com())
    np.testing.assert_array_equal(applied.F_Bq_W.translational(), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(applied.F_Bq_W.rotational(), np.zeros(3))
