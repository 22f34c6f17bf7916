"""Joints of a swinging leg keep to their torques, and to their stops before."""

import numpy as np
import pytest

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.wbc.joint_limits import acceleration_within_limits
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.tasks.momentum import momentum_task
from tests.helpers.walking import robot
from tests.helpers.whole_body import (
    contact_tasks,
    controller_of,
    foot_in_the_air,
    gains_of,
    stack_of,
)

DAMPING = WbcParameters().contact_velocity_gain
KNEE = 3  # number in the leg


def swings(records, dynamics_of):
    """Yield ticks with a foot in the air: its side, dynamics, plan, and their acceleration.

    The latter is a function of the limits.
    """
    control = controller_of()
    for r in [r for r in records if r.targets.swings.any()][::3]:
        side, d, plan = (
            foot_in_the_air(r.targets), dynamics_of(r.x), sample_plan(r.plan, r.targets.time)
        )  # fmt: skip
        tasks, places, feet = stack_of(control, d, r.targets, plan)

        def found(limits, d=d, tasks=tasks, places=places, feet=feet):
            vdot, dropped, _ = acceleration_within_limits(d, tasks, places, feet[:2], limits)
            assert dropped == 0
            return vdot

        yield side, d, plan, found


def torques(d, vdot, side):
    """Of a leg in the air, by the equations of motion [N m]."""
    return (d.M @ vdot + d.Cv - d.tau_g)[robot().leg_v[side]]


@pytest.mark.parametrize("share", [0.9, 0.6, 0.3])
def test_a_swing_asks_no_torque_that_a_joint_does_not_have(records, dynamics_of, share):
    """But for a tenth; feet that stand, momentum and arms do not feel it."""
    h, limits, weakened = robot(), controller_of().constants.limits, 0
    for side, d, plan, found in swings(records, dynamics_of):
        free = found(limits)
        asked = np.abs(torques(d, free, side))
        joint, effort = asked.argmax(), np.full(limits.effort.shape, np.inf)
        effort[side, joint] = share * asked[joint]
        vdot = found(limits._replace(effort=effort))
        assert np.abs(torques(d, vdot, side))[joint] <= 1.1 * effort[side, joint]
        weakened += not np.allclose(vdot, free)
        for task in (
            contact_tasks(d, [1 - side], DAMPING),
            momentum_task(d, plan, h.mass, gains_of()),
        ):
            np.testing.assert_allclose(task.J @ vdot, task.b, atol=1e-6)
        np.testing.assert_allclose(vdot[h.arm_v], free[h.arm_v], atol=1e-6)
    assert weakened > 10


def test_a_stop_comes_before_a_torque(records, dynamics_of):
    """A knee that rushes to its stop is braked there with more torque than it has."""
    h, limits, braked = robot(), controller_of().constants.limits, 0
    for side, d, _, found in swings(records, dynamics_of):
        q, v = d.q[h.leg_q[side, KNEE]], d.v[h.leg_v[side, KNEE]]
        lower, effort = limits.lower.copy(), np.full(limits.effort.shape, np.inf)
        lower[side, KNEE] = q - 0.01
        effort[side, KNEE] = 0.01
        vdot = found(limits._replace(lower=lower, effort=effort))
        least = limits.rate * (limits.rate * (lower[side, KNEE] - q) - 2.0 * v)
        assert vdot[h.leg_v[side, KNEE]] >= least - 1e-6
        braked += abs(torques(d, vdot, side)[KNEE]) > 0.02
    assert braked > 3
