"""Tasks of a user's own: their place in the order, what they cost others, what is refused."""

import numpy as np
import pytest

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.errors import InputError
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.joint_limits import acceleration_within_limits
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.tasks.momentum import momentum_task
from drake_linefoot.wbc.tasks.task import (
    CONTACT,
    MOMENTUM,
    POSTURE,
    SWING,
    Task,
    TaskRows,
    own_rows,
)
from tests.helpers.walking import robot
from tests.helpers.whole_body import computed, foot_in_the_air, stack_of

KNEE = 3
ARM = "left_shoulder_pitch"


class Push(Task):
    """Asks for accelerations of some velocities."""

    def __init__(self, priority, which=(), value=5.0, name="push", joints=()):
        self.name, self.priority, self.joints = name, priority, joints
        self.J, self.b = np.eye(robot().nv)[list(which)], np.full(len(which), value)

    def rows(self, d, targets):
        return TaskRows(self.J, self.b)


def control_of(*tasks):
    return WholeBodyControl(robot(), WbcParameters(), tasks=tasks)


@pytest.fixture(scope="module")
def swinging(records):
    return [r for r in records if r.targets.swings.any()]


def arm():
    h = robot()
    return int(h.actuated_v[h.description.actuated_joints.index(ARM)])


def test_a_task_decides_the_joints_that_it_names(records, dynamics_of):
    """The posture leaves them to it, so nothing is dropped."""
    control = control_of(Push(POSTURE - 1.0, [arm()], joints=[ARM]))
    for r in records[::10]:
        report = computed(control, dynamics_of(r.x), r.targets, r.plan)
        assert report.dropped_rows == 0
        assert report.vdot[arm()] == pytest.approx(5.0, abs=1e-9)


def test_what_comes_first_is_met_and_what_depends_on_it_is_dropped(records, dynamics_of):
    """The same joint without a name in `joints`: above the posture it wins, below it is dropped."""
    above, below = (control_of(Push(priority, [arm()])) for priority in (25.0, POSTURE + 1.0))
    plain = control_of()
    for r in records[::10]:
        d = dynamics_of(r.x)
        one, two, none = (computed(c, d, r.targets, r.plan) for c in (above, below, plain))
        assert one.dropped_rows == two.dropped_rows == 1
        assert one.vdot[arm()] == pytest.approx(5.0, abs=1e-9)
        np.testing.assert_allclose(two.vdot, none.vdot, atol=1e-6)


@pytest.mark.parametrize("priority", [CONTACT - 1.0, 5.0, 15.0, 25.0, 35.0])
def test_rows_stand_where_the_places_say(records, dynamics_of, priority):
    """Wherever one's own come in between."""
    control = control_of()
    c, nv, own = control.constants, robot().nv, np.zeros((3, robot().nv + 2))
    own[:, nv], own[:, nv + 1] = 7.0, priority
    for r in records[::10]:
        d, plan = dynamics_of(r.x), sample_plan(r.plan, r.targets.time)
        plain, before, _ = stack_of(control, d, r.targets, plan)
        rows, places, (contact, swings, *_) = stack_of(control, d, r.targets, plan, own)
        assert np.sum(rows.b == 7.0) >= 3
        assert len(rows.b) == len(plain.b) + 3
        momentum = momentum_task(d, plan, c.mass, c.gains)
        np.testing.assert_array_equal(rows.J[places.momentum :][:6], momentum.J)
        for side in range(2):
            assert (places.contact[side] >= 0, places.swing[side] >= 0) == (
                contact[side], swings[side],
            )  # fmt: skip
        for at, there in ((places.contact, before.contact), (places.swing, before.swing)):
            for here, plainly in zip(at, there, strict=True):
                if here >= 0:
                    np.testing.assert_array_equal(rows.b[here:][:5], plain.b[plainly:][:5])
        joints = len(c.arms.q_d)
        np.testing.assert_array_equal(rows.b[places.posture :][:joints], plain.b[-joints:])


@pytest.mark.parametrize("priority", [MOMENTUM + 1.0, SWING + 1.0])
def test_a_swinging_knee_is_kept_off_its_limit_beside_it(swinging, dynamics_of, priority):
    """Before the swing foot's rows as well as behind them: limits find those by name."""
    h, p = robot(), WbcParameters()
    control = control_of(Push(priority, [arm()], joints=[ARM]))
    for r in swinging[::4]:
        side, x = foot_in_the_air(r.targets), r.x.copy()
        knee = h.leg_v[side, KNEE]
        x[h.leg_q[side, KNEE]], x[h.nq + knee] = 0.15, -4.0
        d = dynamics_of(x)
        away = d.p_WC[side] - d.p_WB
        beyond = d.p_WC[side] + 0.4 * away / np.linalg.norm(away)
        swing = r.targets.swing.copy()
        swing[side, 0] = beyond
        targets = r.targets._replace(swing=swing)
        own, plan = own_rows(control.tasks, d, targets), sample_plan(r.plan, targets.time)
        tasks, places, feet = stack_of(control, d, targets, plan, own)
        limits = control.constants.limits
        vdot, dropped, _ = acceleration_within_limits(d, tasks, places, feet[:2], limits)
        bound = p.joint_limit_rate * (
            p.joint_limit_rate * (p.joint_limit_margin - 0.15) + 2.0 * 4.0
        )
        assert dropped == 0
        assert vdot[knee] == pytest.approx(bound, abs=1e-6)
        assert vdot[arm()] == pytest.approx(5.0, abs=1e-6)
        J, bias = d.J[1 - side], d.Jdot_v[1 - side]
        np.testing.assert_allclose(J @ vdot + bias, -p.contact_velocity_gain * (J @ d.v), atol=1e-5)
        np.testing.assert_array_equal(computed(control, d, targets, r.plan).vdot[6:], vdot[6:])


@pytest.mark.parametrize(
    ("tasks", "match"),
    [
        ([Push(25.0), Push(26.0)], "another task has it"),
        ([Push(25.0, joints=["left_knee"])], "left_knee.*must be of the arms"),
    ],
)
def test_tasks_that_do_not_fit_are_refused(tasks, match):
    with pytest.raises(InputError, match=match):
        control_of(*tasks)


@pytest.mark.parametrize(
    ("J", "b", "match"),
    [
        (np.zeros((1, 3)), np.zeros(1), r"push.*shape \(m, 24\)"),
        (np.zeros((2, 24)), np.zeros(1), "shape"),
        (np.full((1, 24), np.nan), np.zeros(1), "must be finite"),
    ],
)
def test_rows_that_do_not_fit_are_refused_by_name(records, dynamics_of, J, b, match):
    task, r = Push(25.0), records[0]
    task.J, task.b = J, b
    with pytest.raises(InputError, match=match):
        computed(control_of(task), dynamics_of(r.x), r.targets, r.plan)
