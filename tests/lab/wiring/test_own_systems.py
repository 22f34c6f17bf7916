"""Systems of one's own in the closed loop, and the controller in a diagram of one's own."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem
from pydrake.systems.primitives import LogVectorOutput

from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.simulation.recording import WALL_TIMES
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.signals import layouts
from tests.helpers.recorded_runs import SHORT, SIZES, short_run

EXAMPLE = Path(__file__).parents[3] / "examples" / "06_own_diagram.py"


class PlannedForce(LeafSystem):
    """Vertical force that the MPC plans for each foot at its first knot."""

    def __init__(self):
        super().__init__()
        layout = layouts(SIZES)["plan"]
        port = self.DeclareVectorInputPort("plan", layout.size)
        self.DeclareVectorOutputPort(
            "force",
            2,
            lambda context, out: out.SetFromVector(layout.open(port.Eval(context)).wrench[0, :, 2]),
            prerequisites_of_calc={port.ticket()},
        )


def test_any_port_can_be_logged_and_exported_and_the_run_stays_the_same():
    logs = {}

    def extend(builder, ports):
        for name in ("state", "torque", "command"):
            logs[name] = LogVectorOutput(ports[name], builder, publish_period=0.001)
        planned = builder.AddSystem(PlannedForce())
        builder.Connect(ports["plan"], planned.GetInputPort("plan"))
        logs["force"] = LogVectorOutput(planned.get_output_port(), builder, publish_period=0.001)
        builder.ExportOutput(ports["applied_torque"], "applied_torque")

    loop = build_closed_loop(SHORT, extend=extend)
    simulator = loop.make_simulator()
    simulator.AdvanceTo(SHORT.duration)
    run, context = short_run(), simulator.get_context()
    for name, log in logs.items():
        np.testing.assert_allclose(log.FindLog(context).sample_times(), run.time, err_msg=name)
    data = {name: log.FindLog(context).data().T for name, log in logs.items()}
    np.testing.assert_array_equal(data["torque"], run.torque)
    np.testing.assert_array_equal(data["command"], run.command)
    np.testing.assert_array_equal(data["state"][:, 25:], run.v)
    assert 200.0 < data["force"][50:].sum(axis=1).mean() < 280.0  # the robot's weight is 238 N
    exported = loop.GetOutputPort("applied_torque").Eval(context)
    assert exported.shape == (18,) and exported.any()
    for name, values in loop.recorder.arrays().items():
        if name not in WALL_TIMES:
            np.testing.assert_array_equal(values, getattr(run, name), err_msg=name)


@pytest.mark.slow
def test_the_controller_walks_in_a_diagram_of_ones_own_and_pushes_a_box():
    diagram, plant, humanoid, log = runpy.run_path(str(EXAMPLE))["build"](Scenario())
    assert plant.num_positions() == humanoid.nq + 7  # of the free box
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    robot = plant.GetBodyByName("torso").model_instance()
    plant.SetPositionsAndVelocities(context, robot, humanoid.x_nominal)
    box = plant.GetBodyByName("box")
    begin = plant.EvalBodyPoseInWorld(context, box).translation()
    simulator.AdvanceTo(3.0)
    q, end = plant.GetPositions(context, robot), plant.EvalBodyPoseInWorld(context, box)
    assert q[4] > 0.6 and q[6] == pytest.approx(humanoid.q_nominal[6], abs=0.05)
    assert np.hypot(*(end.translation() - begin)[:2]) > 0.3
    torques = log.FindLog(simulator.get_context()).data()
    assert torques.shape[0] == humanoid.na
    assert (np.abs(torques) <= humanoid.effort_limits[:, None] + 1e-9).all()
