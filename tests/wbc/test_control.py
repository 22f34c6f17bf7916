"""One tick of the whole-body controller against the full plant."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.tree import JacobianWrtVariable

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.mpc.ecd_mpc import standing_plan
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.statuses import Mode, Solved
from drake_linefoot.wbc.control import WholeBodyControl, joint_effort
from drake_linefoot.wbc.joint_limits import acceleration_within_limits
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.wrench_qp import solve_program, wrench_program
from tests.helpers.phases import named
from tests.helpers.slow_control import slow_torque
from tests.helpers.walking import ground_cone, mirror_plan, mirror_targets, mirror_wrench
from tests.helpers.whole_body import computed, stack_of, standing

kV = JacobianWrtVariable.kV
EXACT = WbcParameters(solver="clarabel", tolerance=1e-10)


@pytest.fixture(scope="module")
def control(humanoid):
    return WholeBodyControl(humanoid, WbcParameters())


@pytest.fixture(scope="module")
def some(records):
    return records[::8]


def sides_of(record):
    return [i for i in (0, 1) if record.targets.contact[i]]


def test_the_ticks_are_of_every_kind(some):
    assert {named(r.targets) for r in some} >= {Mode.STAND, Mode.SHIFT, Mode.SWING}
    assert {standing(r.targets) for r in some} == {(True, True), (True, False), (False, True)}
    assert {r.report.status for r in some} >= {Solved.UNCONSTRAINED, Solved.ACTIVE_SET}


def test_it_is_what_the_closed_loop_applied(control, dynamics_of, some):
    for r in some:
        report = computed(control, dynamics_of(r.x), r.targets, r.plan)
        np.testing.assert_allclose(report.torque, r.torque, atol=1e-9)
        np.testing.assert_allclose(report.wrench, r.report.wrench, atol=1e-9)
        assert report.milliseconds > 0.0


def test_torques_balance_the_full_dynamics(humanoid, some, full_plant):
    """M vdot + Cv - tau_g - J'f has no rows but the joint torques, to rounding."""
    for r in some:
        assert r.report.clipped == 0
        needed = full_plant.put(r.x).needed_forces(r.report.vdot, r.report.wrench)
        np.testing.assert_allclose(needed[:6], 0.0, atol=1e-8)
        np.testing.assert_allclose(needed[humanoid.actuated_v], r.torque, atol=1e-8)


def test_torques_balance_the_full_dynamics_where_something_pulls(
    humanoid, control, dynamics_of, some, full_plant
):
    """The base has just the moment about the CoM and the force that are said to act there."""
    external = np.array([3.0, -5.0, 2.0, -30.0, 20.0, 15.0])
    for r in some:
        d = dynamics_of(r.x)
        report = computed(control, d, r.targets._replace(external=external), r.plan)
        needed = full_plant.put(r.x).needed_forces(report.vdot, report.wrench)
        moment = external[:3] + np.cross(d.p_WG - d.p_WB, external[3:])
        np.testing.assert_allclose(needed[:6], [*moment, *external[3:]], atol=1e-8)
        if not report.clipped:
            np.testing.assert_allclose(needed[humanoid.actuated_v], report.torque, atol=1e-8)


def test_standing_feet_accelerate_only_against_their_velocity_but_for_the_base_error(
    some, full_plant
):
    gain = WbcParameters().contact_velocity_gain
    for r in some:
        vdot = r.report.vdot.copy()
        vdot[:6] -= r.report.acceleration_error
        full_plant.put(r.x)
        for side in sides_of(r):
            a, alpha = full_plant.line_acceleration(side, vdot)
            v, w = full_plant.line_velocity(side)
            turn = full_plant.line(side)[1][:, 1:].T
            np.testing.assert_allclose(a, -gain * v, atol=1e-7)
            np.testing.assert_allclose(turn @ alpha, -gain * (turn @ w), atol=1e-7)
        assert r.report.dropped_rows == 0


def test_momentum_changes_as_the_wrenches_say(humanoid, some, full_plant):
    """The wrenches are the only outer forces, so they are the rate of linear momentum."""
    plant, context = full_plant.plant, full_plant.context
    for r in some:
        full_plant.put(r.x)
        A = plant.CalcJacobianCenterOfMassTranslationalVelocity(
            context, kV, plant.world_frame(), plant.world_frame()
        )
        bias = plant.CalcBiasCenterOfMassTranslationalAcceleration(
            context, kV, plant.world_frame(), plant.world_frame()
        )
        force = r.report.wrench[:, :3].sum(axis=0)
        expected = force / humanoid.mass + [0.0, 0.0, -9.81]
        np.testing.assert_allclose(A @ r.report.vdot + bias, expected, atol=1e-8)


def test_wrenches_are_inside_their_cones_and_air_carries_none(some, full_plant):
    for r in some:
        full_plant.put(r.x)
        for side in (0, 1):
            w = r.report.wrench[side]
            if side not in sides_of(r):
                np.testing.assert_array_equal(w, 0.0)
                continue
            _, R = full_plant.line(side)
            cone = ground_cone(WbcParameters().friction, 0.075, R, r.targets.slope[side])
            assert (cone @ w).max() < 1e-3
        sample = sample_plan(r.plan, r.targets.time)
        sides = sides_of(r)
        np.testing.assert_allclose(
            r.report.wrench[sides] - sample.wrench[sides], r.report.wrench_error[sides], atol=1e-9
        )


@pytest.mark.parametrize("solver", [None, "clarabel"])
def test_on_slippery_ground_no_foot_asks_for_more_than_its_friction(
    control, dynamics_of, some, full_plant, solver, request
):
    if solver:
        request.getfixturevalue("solver_only")
    pulled, mu = 0, 0.05
    for r in (r for r in some if named(r.targets) == Mode.SWING):
        report = computed(control, dynamics_of(r.x), r.targets._replace(friction=mu), r.plan)
        (side,) = sides_of(r)
        _, R = full_plant.put(r.x).line(side)
        cone = ground_cone(mu, 0.075, R, r.targets.slope[side])
        assert (cone @ report.wrench[side]).max() < 1e-3
        pulled += (cone @ r.report.wrench[side]).max() > 1.0
    assert pulled > 3


@pytest.mark.parametrize("solver", [None, "clarabel", "none that finishes"])
@pytest.mark.parametrize("end", [0, 1])
def test_a_foot_on_one_end_is_not_asked_to_resist_a_turn_about_it(
    humanoid, dynamics_of, some, full_plant, solver, end, request
):
    """The other end is asked for no more force to the side than the little it may have."""
    parameters = WbcParameters(max_iterations=1) if solver == "none that finishes" else EXACT
    control = WholeBodyControl(humanoid, parameters)
    if solver:
        request.getfixturevalue("solver_only")
    turned, X, share, failures = 0, humanoid.half_length, 0.05, 0
    shares = np.ones((2, 2))
    shares[:, 1 - end] = share
    sign = 1.0 if end == 0 else -1.0  # of the other end
    for r in (r for r in some if named(r.targets) == Mode.SWING):
        targets = r.targets._replace(friction_share=shares, slope=np.zeros((2, 2)))
        report = computed(control, dynamics_of(r.x), targets, r.plan)
        (side,) = sides_of(r)
        _, R = full_plant.put(r.x).line(side)
        for wrench, held in ((report.wrench[side], True), (r.report.wrench[side], False)):
            f, (tau_y, tau_z) = R.T @ wrench[:3], wrench[3:]
            aside, normal = 0.5 * (f[1] + sign * tau_z / X), 0.5 * (f[2] - sign * tau_y / X)
            beyond = abs(aside) - share * WbcParameters().friction * normal
            assert beyond < 1e-3 or not held
            turned += beyond > 1.0 and not held
        failures += not report.success
    assert turned > 3
    assert (failures > 3) == (solver == "none that finishes")


def test_the_mpcs_wrenches_are_nearly_used(some):
    """The MPC's trajectories are feasible for the full robot: the paper's Figures 5 and 6."""
    walking = [r for r in some if named(r.targets) == Mode.SWING]
    error = np.array([np.abs(r.report.wrench_error[..., :3]).max() for r in walking])
    assert np.median(error) < 15.0  # [N], of 240
    assert error.max() < 120.0


# --- known answers ----------------------------------------------------------------------


def test_standing_still_it_holds_the_robot_up(humanoid, dynamics_of, records, control, full_plant):
    """Static torques: half the weight on each foot, and no acceleration."""
    x, targets = humanoid.x_nominal, records[0].targets
    report = computed(control, dynamics_of(x), targets, standing_plan(humanoid, MpcParameters()))
    np.testing.assert_allclose(report.vdot, 0.0, atol=0.05)
    np.testing.assert_allclose(report.wrench[:, 2], 0.5 * humanoid.mass * 9.81, rtol=1e-3)
    np.testing.assert_allclose(report.torque, humanoid.mirror_joints(report.torque), atol=1e-6)
    half = np.zeros((2, 5))
    half[:, 2] = 0.5 * humanoid.mass * 9.81
    static = full_plant.put(x).needed_forces(np.zeros(humanoid.nv), half)
    np.testing.assert_allclose(report.torque, static[humanoid.actuated_v], atol=0.15)


def test_in_flight_the_centre_of_mass_falls(humanoid, dynamics_of, records, control, full_plant):
    r = records[100]
    flying = r.targets._replace(contact=np.zeros(2), swings=np.zeros(2))
    report = computed(control, dynamics_of(r.x), flying, r.plan)
    np.testing.assert_array_equal(report.wrench, 0.0)
    assert report.status == Solved.NO_CONTACT
    needed = full_plant.put(r.x).needed_forces(report.vdot, report.wrench)
    np.testing.assert_allclose(needed[:6], 0.0, atol=1e-8)
    if report.clipped == 0:
        np.testing.assert_allclose(needed[humanoid.actuated_v], report.torque, atol=1e-8)


# --- symmetry and gains -----------------------------------------------------------------


def test_mirrored_input_gives_mirrored_torques(humanoid, dynamics_of, some):
    control = WholeBodyControl(humanoid, EXACT)
    for r in some:
        one = computed(control, dynamics_of(r.x), r.targets, r.plan)
        x = humanoid.mirror_state(r.x)
        other = computed(control, dynamics_of(x), mirror_targets(r.targets), mirror_plan(r.plan))
        np.testing.assert_allclose(other.torque, humanoid.mirror_joints(one.torque), atol=1e-4)
        np.testing.assert_allclose(other.wrench, mirror_wrench(one.wrench), atol=1e-3)


@pytest.mark.parametrize(
    "changes",
    [
        {"com_position_gain": 20.0}, {"com_velocity_gain": 5.0}, {"angular_momentum_gain": 10.0},
        {"swing_position_gain": 900.0}, {"swing_velocity_gain": 30.0}, {"arm_position_gain": 30.0},
        {"arm_velocity_gain": 5.0}, {"contact_velocity_gain": 10.0}, {"friction": 0.1},
        {"force_error_weight": 10.0}, {"torque_error_weight": 10.0},
        {"acceleration_error_weight": 0.01}, {"angular_acceleration_error_weight": 0.01},
    ],
)  # fmt: skip
def test_every_gain_and_weight_has_an_effect(humanoid, dynamics_of, records, control, changes):
    """A parameter that nothing reads would leave every torque of the walk as it is."""
    other = WholeBodyControl(humanoid, replace(WbcParameters(), **changes))
    difference = 0.0
    for r in records[60::25]:
        d = dynamics_of(r.x)
        one, two = computed(control, d, r.targets, r.plan), computed(other, d, r.targets, r.plan)
        difference = max(difference, np.abs(one.torque - two.torque).max())
    assert difference > 1e-3


def test_a_tick_is_that_of_its_parts(control, dynamics_of, records):
    """In every number, to rounding; no tick of the walk needs the solver."""
    c = control.constants
    for r in records[::3]:
        d, plan, t = dynamics_of(r.x), sample_plan(r.plan, r.targets.time), r.targets
        tasks, places, feet = stack_of(control, d, t, plan)
        contact = feet[0]
        vdot, dropped, positive = acceleration_within_limits(d, tasks, places, feet[:2], c.limits)
        ground = t.slope, t.friction, t.friction_share
        program = wrench_program(d, vdot, contact, plan.wrench, ground, t.external, c.weights)
        delta, active, found = solve_program(program, c.weights.weight)
        effort = joint_effort(d, vdot, program, delta, contact, c)
        report = computed(control, d, t, r.plan)
        assert positive
        assert (report.success, report.dropped_rows) == (found, dropped) == (True, 0)
        assert report.status == (Solved.ACTIVE_SET if active else Solved.UNCONSTRAINED)
        assert report.active == active
        assert report.clipped == effort.clipped
        for name in ("torque", "wrench", "wrench_error", "acceleration_error", "vdot"):
            np.testing.assert_allclose(getattr(report, name), getattr(effort, name), atol=1e-10)


# --- the slow form --------------------------------------------------------------------------


def test_torques_are_those_of_the_slow_form(humanoid, dynamics_of, control, records):
    """To a billionth without an active cone, and with one as exactly as Clarabel solves.

    The slow form knows no stops of joints, so they are moved out of the way.
    """
    kinds, same = set(), []
    free = WholeBodyControl(humanoid, WbcParameters(joint_limit_margin=0.0, joint_limit_rate=1e4))
    for r in records[::3]:
        slow, active = slow_torque(humanoid, WbcParameters(), r.x, r.targets, r.plan)
        d = dynamics_of(r.x)
        report = computed(free, d, r.targets, r.plan)
        same.append(np.array_equal(report.torque, computed(control, d, r.targets, r.plan).torque))
        kinds.add((named(r.targets), active))
        limit = humanoid.effort_limits
        slow = np.clip(slow, -limit, limit)
        np.testing.assert_allclose(report.torque, slow, rtol=0, atol=1e-4 if active else 1e-9)
    assert {(Mode.SWING, True), (Mode.SWING, False), (Mode.STAND, False)} <= kinds
    assert np.mean(same) > 0.9
