"""The state machine of the gait: one tick.

`s` is the gait's state, see `state.GAIT`, which every function changes in place, and `c` are its
constants, see `gait_constants`.
"""

import numpy as np

from drake_linefoot.contact.wrench_cone import ground_frame
from drake_linefoot.gait.command import allowed_command, follow_command
from drake_linefoot.gait.footing import (
    forces_on_ground,
    grips_whole,
    is_at_stop,
    learn_bearing,
    learn_friction,
    learn_grip,
    load_shares,
    present_slip,
    regain_friction,
)
from drake_linefoot.gait.footsteps import settle_time, swing_duration, weight_shift
from drake_linefoot.gait.ground import (
    feel_slope,
    height_of_swing,
    learn_slope,
    learn_unevenness,
    line_pitch,
    pressed_point,
)
from drake_linefoot.gait.learning import forget_marks, forget_speed, learn_speed
from drake_linefoot.gait.measurement import GaitMeasurement, lean_into, measure_gait
from drake_linefoot.gait.next_stance import next_stance
from drake_linefoot.gait.standing import foot_towards, outside_feet
from drake_linefoot.gait.state import DOUBLE, GAIT, PITCH, SHIFT, STAND, SWING, YAW, Records, Z
from drake_linefoot.gait.swing import base_motion
from drake_linefoot.gait.touchdown import aim, ends_beside, planned_height
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.rotation import wrap_angle
from drake_linefoot.signals import RobotDynamics, open_contact, open_dynamics
from drake_linefoot.types import Array

TIME_EPSILON = 1e-9  # [s]
_REACH_AHEAD = 0.005  # [s] a foot that reaches down is planned to stand so soon


def begin(measured: GaitMeasurement, time: float, c: np.record) -> np.record:
    """Return the state of a robot that stands where it is measured at `time` [s]."""
    s: np.record = np.zeros(1, GAIT)[0]
    feet = measured.feet
    s.begun, s.time, s.phase_start, s.side = 1, time, time, c.first_stance
    s.phase_end = s.due = np.inf
    s.yaw = feet[0, 3] + 0.5 * wrap_angle(feet[1, 3] - feet[0, 3])
    s.speed_scale[:], s.swing_height = c.speed_scale, c.swing_height
    s.friction, s.bearing[:], s.grip[:] = 1.0, 0.5, 1.0
    s.com[:], s.com_velocity[:], s.feet[:] = measured.com, measured.com_velocity, feet
    s.pendulum_com[:], s.pendulum_velocity[:] = measured.com, measured.pendulum_velocity
    forget_marks(s)
    return s


@compiled
def update(
    gait: Records,
    command: Array,
    dynamics: Array,
    estimate: Array,
    time: float,
    constants: Records,
) -> None:
    """Advance the gait to `time`.

    Args:
        gait: state at an earlier time; like the constants an array of one record, shape (1,),
            for to take over two records from Python takes 6 us longer.
        command: [v_x, v_y, turn rate, walk], heading frame [m/s, m/s, rad/s, 0 or 1], shape (4,).
        dynamics: `RobotDynamics` at `time`, as they travel.
        estimate: `ContactEstimate`, likewise.
        time: [s].
        constants: of the gait.
    """
    s, c, nv = gait[0], constants[0], len(estimate) - 18
    d, seen = open_dynamics(dynamics, nv), open_contact(estimate, nv)
    measured, dt, walk = (
        measure_gait(d, seen.contact, seen.wrench, c),
        time - s.time,
        command[3] > 0.5,
    )
    follow_command(s, command, dt, c)
    s.com[:], s.com_velocity[:] = measured.com, measured.com_velocity
    s.external[:], s.lean[:] = seen.external, lean_into(seen.external, d.M[3, 3], c)
    s.pendulum_com[:], s.pendulum_velocity[:] = measured.com, measured.pendulum_velocity
    s.pendulum_com[:2] += s.lean
    for foot in range(2):
        if s.mode != SWING or foot == s.side:
            s.feet[foot] = measured.feet[foot]
    if s.mode >= SWING and seen.contact[int(s.side)] > 0.5:
        feel_foot(s, d, seen.wrench[int(s.side)], dt, c)
    if s.mode == SWING:
        remaining = s.phase_end - settle_time(s, c) - s.time
        moved = base_motion(s.reference[:], s.target[:], remaining, np.array((dt,)))
        s.reference[:] = moved[:, 0]
    s.time = time
    change_phase(s, command, measured, dt, c)
    if s.mode == SWING and s.phase_start == time:
        placed = aim(s, c)  # for `ends_beside`
        s.closing = not walk and not placed and ends_beside(s, c)
    if s.mode == SWING and time - dt < s.phase_start + c.slope_feel_time - TIME_EPSILON <= time:
        feel_ground(s, measured, c)
    if s.mode == SWING and s.phase_end - time > settle_time(s, c) + c.freeze_time:
        aim(s, c)


@compiled
def feel_foot(s: np.record, d: RobotDynamics, wrench: Array, dt: float, c: np.record) -> None:
    """Learn which ends of the stance foot bear load and grip, and the friction if it slides.

    `wrench` is what the contact estimator says of it, shape (5,); the rest is as of `update`.
    """
    side = int(s.side)
    R_WS = ground_frame(d.R_WC[side], s.slope[:])
    forces = forces_on_ground(wrench, d.R_WC[side], R_WS, c)
    shares = s.bearing.copy()
    if not is_at_stop(d.q[int(c.ankle_q[side])], side, c):
        shares = load_shares(shares, forces)
        s.bearing[:] = learn_bearing(s.bearing[:], shares, dt)
    turns = c.half_length * abs(d.w_WF[side, 2]) > c.contact_speed
    s.grip[side] = learn_grip(s.grip[side], s.bearing[:], shares, turns)
    if present_slip(s) > c.slip_min:
        motion, before = (d.v_WC[side], d.w_WF[side]), s.friction
        s.friction = learn_friction(before, motion, forces, R_WS, c)
        if s.friction != before:
            s.slides = 1


@compiled
def feel_ground(s: np.record, measured: GaitMeasurement, c: np.record) -> None:
    """Learn of the slope from the stance foot, unless it may stand on the edge of a tile."""
    side, even = int(s.side), s.unevenness <= c.unevenness_max
    if even and abs(measured.climb[side]) < c.contact_speed:
        yaw, rise = s.feet[side, 3], measured.rise[side]
        s.slope[:] = feel_slope(s.slope[:], yaw, rise, c.slope_learning, c.slope_max)


@compiled
def change_phase(
    s: np.record, command: Array, measured: GaitMeasurement, dt: float, c: np.record
) -> None:
    """Start the next phase where the present one is over; a late swing foot reaches down."""
    walk, over = command[3] > 0.5, s.time >= s.phase_end - TIME_EPSILON
    if s.mode <= SHIFT and outside_feet(s, c) > 0.0:
        step_out(s, c)
    elif s.mode == STAND:
        if walk:  # nothing is known of its speed yet
            start(s, SHIFT, int(c.first_stance), c.shift_duration)
            forget_speed(s, c)
    elif s.mode == SHIFT:
        if not walk:
            start(s, STAND, int(s.side), np.inf)
        elif over:
            start(s, DOUBLE, int(s.side), c.double_support)
    elif s.mode == DOUBLE:
        if over:
            lift(s, c)
    elif has_landed(s, measured, c):
        touch_down(s, command, measured, c)
    elif c.contact_feedback and s.time >= s.due - TIME_EPSILON:
        reach_down(s, dt, c)


@compiled
def step_out(s: np.record, c: np.record) -> None:
    """Begin to step with the foot towards which the DCM has gone."""
    start(s, DOUBLE, 1 - foot_towards(s, c), c.double_support)
    forget_speed(s, c)


@compiled
def start(s: np.record, mode: float, side: int, duration: float) -> None:
    """Start a phase in which the weight is on `side`, or goes there, for a time [s]."""
    if mode != SWING or side != s.side:
        s.bearing[:], s.grip[:] = 0.5, 1.0
    s.mode, s.side, s.closing, s.again = mode, side, 0, 0
    s.phase_start, s.phase_end = s.time, s.time + duration
    if mode == STAND:
        s.velocity[:], s.turn_rate, s.hurried = 0.0, 0.0, 0


@compiled
def lift(s: np.record, c: np.record) -> None:
    """Lift the foot the weight has left, or is to leave, from where it stands."""
    side, _ = next_stance(s, int(s.side), 0.0, c)
    if side != int(s.side):
        forget_marks(s)
    start(s, SWING, side, swing_duration(s.velocity[0], c))
    foot, s.due = s.feet[1 - int(s.side)], s.phase_end
    s.planted[:] = s.feet[int(s.side), :2]
    s.reference[:] = 0.0
    s.reference[0, :3], s.reference[0, YAW] = foot[:3], foot[3]
    s.reference[0, PITCH] = line_pitch(s.slope[:], foot[3])
    s.target[:] = s.reference[0]


@compiled
def has_landed(s: np.record, measured: GaitMeasurement, c: np.record) -> bool:
    """Return whether the swing foot has found the ground, or is to stand without it."""
    if not c.contact_feedback:
        return bool(s.time >= s.phase_end - TIME_EPSILON)
    foot, late = 1 - int(s.side), s.time - s.due
    share = (s.time - s.phase_start) / (s.due - s.phase_start)
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
    above = measured.feet[foot, Z] - s.reference[0, Z]
    if late >= c.late_contact_wait - TIME_EPSILON and stays and above < c.late_contact_height:
        return True
    return late >= late_contact_time(s, c) - TIME_EPSILON


@compiled
def late_contact_time(s: np.record, c: np.record) -> float:
    """Return how long a late foot is waited for [s].

    Not so long that the step gets longer than `step_length` at the present speed.
    """
    speed, step = abs(s.velocity[0]), s.due - s.phase_start + c.double_support
    if speed * (step + c.late_contact_max) <= c.step_length:
        return float(c.late_contact_max)
    return max(c.step_length / speed - step, 0.0)


@compiled
def reach_down(s: np.record, dt: float, c: np.record) -> None:
    """Move a late foot straight down, and plan to stand on it soon."""
    s.phase_end = s.time + _REACH_AHEAD
    s.reference[1:] = 0.0
    s.reference[0, Z] -= c.reach_speed * dt
    s.reference[1, Z] = -c.reach_speed
    s.target[:] = s.reference[0]


@compiled
def touch_down(s: np.record, command: Array, measured: GaitMeasurement, c: np.record) -> None:
    """Stand on the swing foot from now on, and learn of the ground and of the speed."""
    side, foot, allowed = int(s.side), 1 - int(s.side), allowed_command(s, command, c)[0]
    steady = s.velocity[0] == allowed[0] and s.velocity[1] == allowed[1]
    s.steps += 1
    s.feet[foot] = measured.feet[foot]
    s.friction, s.slides = regain_friction(s.friction, s.slides > 0.0), 0.0
    touches = pressed_point(s.feet[foot], measured.rise[foot], measured.presses[foot])
    s.unevenness = learn_unevenness(s.unevenness, s.slope[:], s.feet[side], touches)
    s.swing_height = height_of_swing(s.unevenness, c)
    lies = s.unevenness <= c.unevenness_max or grips_whole(s.grip[side])
    rise, share = measured.rise[side], c.slope_learning * lies
    s.slope[:] = learn_slope(
        s.slope[:], s.feet[:], side, rise, share, c.slope_max, c.slope_baseline
    )
    learn_speed(s, bool(steady), c)
    if s.closing:
        start(s, STAND, side, np.inf)
    else:
        shift_weight(s, foot, c)


@compiled
def shift_weight(s: np.record, foot: int, c: np.record) -> None:
    """Begin the double support after the touchdown of a foot, and say which one swings next."""
    stance, short = next_stance(s, foot, weight_shift(s, c)[0], c)
    s.hurried = c.hurried_steps if short else max(s.hurried - 1.0, 0.0)
    start(s, DOUBLE, stance, weight_shift(s, c)[0])
    if stance != foot:
        s.again = 1
        forget_marks(s)
