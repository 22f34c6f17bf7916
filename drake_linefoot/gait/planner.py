"""The state machine of the gait: one tick."""

import numpy as np

from drake_linefoot.gait.clock import advance_clock, close_step, count_step, start_phase
from drake_linefoot.gait.command import allowed_command, follow_command, halt
from drake_linefoot.gait.footing import end_stance, feel_foot, forget_footing, plant
from drake_linefoot.gait.footsteps import settle_time, swing_duration, weight_shift
from drake_linefoot.gait.ground import feel_ground, meet_ground
from drake_linefoot.gait.learning import forget_marks, forget_speed, learn_speed
from drake_linefoot.gait.measurement import GaitMeasurement, measure_gait, take_in, take_in_foot
from drake_linefoot.gait.next_stance import next_stance
from drake_linefoot.gait.recovery import forget_hurry, note_stance, swing_again
from drake_linefoot.gait.standing import foot_towards, outside_feet
from drake_linefoot.gait.state import (
    DOUBLE,
    SHIFT,
    STAND,
    SWING,
    GaitConstants,
    GaitState,
    Records,
    Z,
    new_state,
)
from drake_linefoot.gait.swing_foot import carry_on, fit_height, lift_foot, reach_down
from drake_linefoot.gait.touchdown import aim, ends_beside, planned_height
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.rotation import wrap_angle
from drake_linefoot.signals import open_contact, open_dynamics
from drake_linefoot.types import Array

TIME_EPSILON = 1e-9  # [s]


def begin(measured: GaitMeasurement, time: float, c: GaitConstants) -> GaitState:
    """Return the state of a robot that stands where it is measured at `time` [s]."""
    s, feet = new_state(), measured.feet
    s.clock.begun, s.clock.time, s.clock.phase_start, s.clock.side = 1, time, time, c.first_stance
    s.clock.phase_end = s.clock.due = np.inf
    s.command.yaw = feet[0, 3] + 0.5 * wrap_angle(feet[1, 3] - feet[0, 3])
    s.speed.scale[:], s.swing.height = c.speed_scale, c.swing_height
    s.footing.friction, s.footing.bearing[:], s.footing.grip[:] = 1.0, 0.5, 1.0
    s.robot.com[:], s.robot.com_velocity[:] = measured.com, measured.com_velocity
    s.robot.pendulum_com[:], s.robot.feet[:] = measured.com, feet
    s.robot.pendulum_velocity[:] = measured.pendulum_velocity
    forget_marks(s)
    return s


@compiled
def update(
    gait: Records,
    command: Array,
    dynamics: Array,
    estimate: Array,
    nw: int,
    time: float,
    constants: Records,
) -> None:
    """Advance the gait to `time`.

    Args:
        gait: a `GaitState` of an earlier time, changed in place; like the constants an array of one
            record, shape (1,), for to take over two records from Python takes 6 us longer.
        command: [v_x, v_y, turn rate, walk], heading frame [m/s, m/s, rad/s, 0 or 1], shape (4,).
        dynamics: `RobotDynamics` at `time`, as they travel.
        estimate: `ContactEstimate`, likewise.
        nw: how many numbers the wrench of a foot has.
        time: [s].
        constants: `GaitConstants`.
    """
    s: GaitState = gait[0]
    c: GaitConstants = constants[0]
    nv = len(estimate) - 2 * nw - 8
    d, seen = open_dynamics(dynamics, nv, nw), open_contact(estimate, nv, nw)
    measured = measure_gait(d, seen.contact, seen.wrench, c)
    dt, walk = time - s.clock.time, command[3] > 0.5
    follow_command(s, command, dt, c)
    take_in(s, measured, seen.external, d.M[3, 3], c)
    stance = int(s.clock.side)
    if s.clock.mode >= SWING and seen.contact[stance] > 0.5:
        feel_foot(s, d, seen.wrench[stance], dt, c)
    if s.clock.mode == SWING:
        carry_on(s, dt, c)
    advance_clock(s, time)
    change_phase(s, command, measured, dt, c)
    if s.clock.mode == SWING and s.clock.phase_start == time:
        placed = aim(s, c)  # for `ends_beside`
        close_step(s, not walk and not placed and ends_beside(s, c))
    felt = s.clock.phase_start + c.slope_feel_time - TIME_EPSILON
    if s.clock.mode == SWING and time - dt < felt <= time:
        feel_ground(s, measured, c)
    if s.clock.mode == SWING and s.clock.phase_end - time > settle_time(s, c) + c.freeze_time:
        aim(s, c)


@compiled
def change_phase(
    s: GaitState, command: Array, measured: GaitMeasurement, dt: float, c: GaitConstants
) -> None:
    """Start the next phase where the present one is over; a late swing foot reaches down."""
    walk, over = command[3] > 0.5, s.clock.time >= s.clock.phase_end - TIME_EPSILON
    if s.clock.mode <= SHIFT and outside_feet(s, c) > 0.0:
        step_out(s, c)
    elif s.clock.mode == STAND:
        if walk:  # nothing is known of its speed yet
            start(s, SHIFT, int(c.first_stance), c.shift_duration)
            forget_speed(s, c)
    elif s.clock.mode == SHIFT:
        if not walk:
            start(s, STAND, int(s.clock.side), np.inf)
        elif over:
            start(s, DOUBLE, int(s.clock.side), c.double_support)
    elif s.clock.mode == DOUBLE:
        if over:
            lift(s, c)
    elif has_landed(s, measured, c):
        touch_down(s, command, measured, c)
    elif c.contact_feedback and s.clock.time >= s.clock.due - TIME_EPSILON:
        reach_down(s, dt, c)


@compiled
def step_out(s: GaitState, c: GaitConstants) -> None:
    """Begin to step with the foot towards which the DCM has gone."""
    start(s, DOUBLE, 1 - foot_towards(s, c), c.double_support)
    forget_speed(s, c)


@compiled
def start(s: GaitState, mode: float, side: int, duration: float) -> None:
    """Start a phase in which the weight is on `side`, or goes there, for a time [s]."""
    if mode != SWING or side != s.clock.side:
        forget_footing(s)
    start_phase(s, mode, side, duration)
    swing_again(s, False)
    if mode == STAND:
        halt(s)
        forget_hurry(s)


@compiled
def lift(s: GaitState, c: GaitConstants) -> None:
    """Lift the foot the weight has left, or is to leave, from where it stands."""
    side, _ = next_stance(s, int(s.clock.side), 0.0, c)
    if side != int(s.clock.side):
        forget_marks(s)
    start(s, SWING, side, swing_duration(s.command.velocity[0], c))
    plant(s)
    lift_foot(s, 1 - side)


@compiled
def has_landed(s: GaitState, measured: GaitMeasurement, c: GaitConstants) -> bool:
    """Return whether the swing foot has found the ground, or is to stand without it."""
    if not c.contact_feedback:
        return bool(s.clock.time >= s.clock.phase_end - TIME_EPSILON)
    foot, late = 1 - int(s.clock.side), s.clock.time - s.clock.due
    share = (s.clock.time - s.clock.phase_start) / (s.clock.due - s.clock.phase_start)
    # A push on the torso looks like a force on the foot, but stops neither end of it.
    stopped = measured.climb[foot] > -c.contact_speed
    if measured.contact[foot] > 0.5 and share >= c.early_contact_phase and stopped:
        above, climb = planned_height(s)  # up at its apex it has not stopped, it turns round
        held = climb < min(-c.contact_speed, 2.0 * measured.climb[foot])
        if held or late >= 0.0 or above < c.late_contact_height:
            return True
    # A late foot that is moved down and does not go down has found the ground, whatever the forces
    # look like: to the estimator a push on the torso may hide the force on a foot.
    stays = measured.climb[foot] > -0.25 * c.reach_speed
    above = measured.feet[foot, Z] - s.swing.reference[0, Z]
    if late >= c.late_contact_wait - TIME_EPSILON and stays and above < c.late_contact_height:
        return True
    return late >= late_contact_time(s, c) - TIME_EPSILON


@compiled
def late_contact_time(s: GaitState, c: GaitConstants) -> float:
    """Return how long a late foot is waited for [s].

    Not so long that the step gets longer than `step_length` at the present speed.
    """
    speed, step = abs(s.command.velocity[0]), s.clock.due - s.clock.phase_start + c.double_support
    if speed * (step + c.late_contact_max) <= c.step_length:
        return float(c.late_contact_max)
    return max(c.step_length / speed - step, 0.0)


@compiled
def touch_down(s: GaitState, command: Array, measured: GaitMeasurement, c: GaitConstants) -> None:
    """Stand on the swing foot from now on, and learn of the ground and of the speed."""
    side, foot, allowed = (
        int(s.clock.side),
        1 - int(s.clock.side),
        allowed_command(s, command, c)[0],
    )
    velocity = s.command.velocity
    steady = velocity[0] == allowed[0] and velocity[1] == allowed[1]
    count_step(s)
    take_in_foot(s, measured, foot)
    end_stance(s)
    meet_ground(s, measured, c)
    fit_height(s, c)
    learn_speed(s, bool(steady), c)
    if s.clock.closing:
        start(s, STAND, side, np.inf)
    else:
        shift_weight(s, foot, c)


@compiled
def shift_weight(s: GaitState, foot: int, c: GaitConstants) -> None:
    """Begin the double support after the touchdown of a foot, and say which one swings next."""
    stance, short = next_stance(s, foot, weight_shift(s, c)[0], c)
    note_stance(s, short, c)
    start(s, DOUBLE, stance, weight_shift(s, c)[0])
    if stance != foot:
        swing_again(s, True)
        forget_marks(s)
