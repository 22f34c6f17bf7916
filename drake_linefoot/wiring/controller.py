"""The controller as one Diagram: state in, torque out."""

from __future__ import annotations

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_linefoot.contact.contact_estimator import ContactEstimator
from drake_linefoot.gait.centroidal_reference import CentroidalReference
from drake_linefoot.gait.gait_planner import GaitPlanner
from drake_linefoot.mpc.ecd_mpc import EcdMpc
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.scenario import Scenario
from drake_linefoot.wbc.whole_body_controller import WholeBodyController


def build_controller(humanoid: Humanoid, scenario: Scenario) -> Diagram:
    """Wire estimator, gait, reference, MPC and whole-body controller.

    Input ports: `state` (nq + nv), `command` (4), `applied_torque` (na). Output ports:
    `torque` (na), and the signals `contact`, `targets`, `reference`, `plan`, `report`.

    Args:
        humanoid: the robot.
        scenario: parameters of the blocks.

    Returns:
        The diagram, named "controller".
    """
    s = scenario
    builder = DiagramBuilder()
    estimator = builder.AddSystem(ContactEstimator(humanoid, s.estimator))
    gait = builder.AddSystem(GaitPlanner(humanoid, s.gait, s.mpc.knots * s.mpc.knot_step))
    reference = builder.AddSystem(CentroidalReference(humanoid, s.mpc, s.gait))
    mpc = builder.AddSystem(EcdMpc(humanoid, s.mpc))
    wbc = builder.AddSystem(WholeBodyController(humanoid, s.wbc))

    builder.Connect(estimator.get_contact_output_port(), gait.get_contact_input_port())
    builder.Connect(gait.get_horizon_output_port(), reference.get_horizon_input_port())
    builder.Connect(reference.get_reference_output_port(), mpc.get_reference_input_port())
    builder.Connect(gait.get_targets_output_port(), wbc.get_targets_input_port())
    builder.Connect(mpc.get_plan_output_port(), wbc.get_plan_input_port())

    state = builder.ExportInput(estimator.get_state_input_port(), "state")
    for block in (gait, reference, mpc, wbc):
        builder.ConnectInput(state, block.get_state_input_port())
    builder.ExportInput(gait.get_command_input_port(), "command")
    builder.ExportInput(estimator.get_applied_torque_input_port(), "applied_torque")
    builder.ExportOutput(wbc.get_torque_output_port(), "torque")
    builder.ExportOutput(estimator.get_contact_output_port(), "contact")
    builder.ExportOutput(gait.get_targets_output_port(), "targets")
    builder.ExportOutput(reference.get_reference_output_port(), "reference")
    builder.ExportOutput(mpc.get_plan_output_port(), "plan")
    builder.ExportOutput(wbc.get_report_output_port(), "report")
    diagram = builder.Build()
    diagram.set_name("controller")
    return diagram
