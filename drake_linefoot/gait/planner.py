"""One tick of the gait: what is measured, contacts that change, swings that go on."""

from drake_linefoot.gait.clock import (
    advance_clock,
    count_step,
    end_walk,
    land_foot,
    lift_foot,
    load_foot,
    stand_still,
)
from drake_linefoot.gait.command import allowed_command, choose_gait, follow_command, halt
from drake_linefoot.gait.contacts import (
    in_contact,
    in_double_support,
    in_final_step,
    is_stepping,
    standing_still,
)
from drake_linefoot.gait.footing import (
    end_stance,
    forget_footing,
    set_stance_anchor,
    update_footing_estimate,
)
from drake_linefoot.gait.footsteps import settle_time, swing_time, weight_shift
from drake_linefoot.gait.ground import (
    update_ground_estimate_at_touchdown,
    update_ground_estimate_in_stance,
)
from drake_linefoot.gait.known_ground import is_near_patch, level_between
from drake_linefoot.gait.learning import (
    clear_touchdown_history,
    forget_speed,
    update_speed_estimate,
)
from drake_linefoot.gait.measurement import GaitMeasurement, measure_gait, take_in, take_in_foot
from drake_linefoot.gait.next_stance import next_stance
from drake_linefoot.gait.recovery import end_recovery, note_stance
from drake_linefoot.gait.running import update_run_foothold
from drake_linefoot.gait.standing import foot_towards, outside_feet
from drake_linefoot.gait.state import GaitConstants, GaitState, Records, Z, new_state
from drake_linefoot.gait.swing_foot import begin_swing, carry_on, fit_height, reach_down
from drake_linefoot.gait.told_ground import correct_heights, set_level, take_in_terrain
from drake_linefoot.gait.touchdown import ends_beside, planned_height, update_foothold
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.rotation import wrap_angle
from drake_linefoot.parts import FOREVER
from drake_linefoot.signals import open_contact, open_dynamics
from drake_linefoot.types import Array

TIME_EPSILON = 1e-9  # [s]


def begin(measured: GaitMeasurement, time: float, c: GaitConstants) -> GaitState:
    """Return the state of a robot that stands where it is measured at `time` [s]."""
    s, feet = new_state(), measured.feet
    s.clock.initialized, s.clock.time, s.clock.side = 1, time, c.first_stance
    s.terrain.count = 1.0
    s.clock.touchdown[:], s.clock.planned_touchdown[:], s.clock.lift_off[:] = time, time, FOREVER
    s.swing.lifted[:] = feet[:, :3]
    s.command.yaw = feet[0, 3] + 0.5 * wrap_angle(feet[1, 3] - feet[0, 3])
    s.speed.scale[:], s.swing.height[:] = c.speed_scale, c.swing_height
    s.footing.friction, s.footing.load_shares[:], s.footing.friction_shares[:] = 1.0, 0.5, 1.0
    s.robot.com[:], s.robot.com_velocity[:] = measured.com, measured.com_velocity
    s.robot.pendulum_com[:], s.robot.feet[:] = measured.com, feet
    s.robot.pendulum_velocity[:] = measured.pendulum_velocity
    clear_touchdown_history(s)
    return s


@compiled
def update(
    gait: Records,
    command: Array,
    dynamics: Array,
    estimate: Array,
    nw: int,
    terrain: Array,
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
        terrain: `Terrain`, as it travels.
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
    take_in_terrain(s, terrain, c)
    stance, stepping = int(s.clock.side), is_stepping(s)
    if stepping and seen.contact[stance] > 0.5:
        update_footing_estimate(s, d, seen.wrench[stance], dt, c)
    for foot in range(2):
        if not in_contact(s, foot):
            carry_on(s, foot, dt, c)
    advance_clock(s, time)
    if stepping:
        change_contacts(s, command, measured, dt, c)
    else:
        set_level(s, min(s.robot.feet[0, 2], s.robot.feet[1, 2]))
        begin_steps(s, walk, c)
    for foot in range(2):
        if not in_contact(s, foot):
            guide_swing(s, foot, measured, walk, dt, c)


@compiled
def begin_steps(s: GaitState, walk: bool, c: GaitConstants) -> None:
    """Let a robot that stands wait for its first step, begin it, or go on standing."""
    if outside_feet(s, c) > 0.0:
        step_out(s, c)
    elif standing_still(s):
        if walk:  # nothing is known of its speed yet
            first = int(c.first_stance)
            forget_footing(s)
            load_foot(s, first, s.clock.time + c.shift_duration, c.double_support)
            forget_speed(s, c)
    elif not walk:
        end_steps(s)
    elif s.clock.time >= s.clock.touchdown[int(s.clock.side)] - TIME_EPSILON:
        load_foot(s, int(s.clock.side), s.clock.time, c.double_support)


@compiled
def step_out(s: GaitState, c: GaitConstants) -> None:
    """Begin to step with the foot towards which the DCM has gone."""
    forget_footing(s)
    load_foot(s, 1 - foot_towards(s, c), s.clock.time, c.double_support)
    forget_speed(s, c)


@compiled
def end_steps(s: GaitState) -> None:
    """Stand on both feet from now on."""
    forget_footing(s)
    stand_still(s)
    halt(s)
    end_recovery(s)


@compiled
def change_contacts(
    s: GaitState, command: Array, measured: GaitMeasurement, dt: float, c: GaitConstants
) -> None:
    """Stand on feet that have landed, and lift those whose time it is; a late one reaches down."""
    for foot in range(2):
        late = s.clock.time >= s.clock.planned_touchdown[foot] - TIME_EPSILON
        if in_contact(s, foot):
            continue
        if has_landed(s, foot, measured, c):
            touch_down(s, foot, command, measured, c)
        elif c.contact_feedback and late:
            reach_down(s, foot, dt, c)
    for foot in range(2):
        if in_contact(s, foot) and s.clock.time >= s.clock.lift_off[foot] - TIME_EPSILON:
            lift(s, foot, c)


@compiled
def guide_swing(
    s: GaitState, foot: int, measured: GaitMeasurement, walk: bool, dt: float, c: GaitConstants
) -> None:
    """Update where a foot that swings lands, and feel the ground with the one that stands."""
    time, start = s.clock.time, s.clock.lift_off[foot]
    runs, bears = s.command.flight > 0.0, max(start, s.clock.touchdown[1 - foot])
    if start == time and not runs:
        placed = update_foothold(s, foot, c)  # for `ends_beside`
        end_walk(s, not walk and not placed and ends_beside(s, foot, c))
    felt = bears + c.slope_feel_time - TIME_EPSILON
    if in_contact(s, 1 - foot) and time - dt < felt <= time:
        update_ground_estimate_in_stance(s, measured, c)
    if s.clock.touchdown[foot] - time > settle_time(s, c) + c.freeze_time:
        if runs:
            update_run_foothold(s, foot, c)
        else:
            update_foothold(s, foot, c)


@compiled
def lift(s: GaitState, foot: int, c: GaitConstants) -> None:
    """Lift the foot the weight has left, or rather the other one, from where it stands."""
    duration = swing_time(s, c)
    if s.command.flight > 0.0:  # later than in a run, as the first foot of it is
        duration -= s.command.flight if in_contact(s, 1 - foot) else 0.0
    elif in_double_support(s):
        stance, _ = next_stance(s, int(s.clock.side), 0.0, c)
        if stance != int(s.clock.side):
            clear_touchdown_history(s)
            forget_footing(s)
        foot = 1 - stance
    lift_foot(s, foot, duration)
    set_stance_anchor(s)
    begin_swing(s, foot, c)


@compiled
def has_landed(s: GaitState, foot: int, measured: GaitMeasurement, c: GaitConstants) -> bool:
    """Return whether a foot that swings has found the ground, or is to stand without it."""
    if not c.contact_feedback:
        return bool(s.clock.time >= s.clock.touchdown[foot] - TIME_EPSILON)
    start, planned = s.clock.lift_off[foot], s.clock.planned_touchdown[foot]
    late, share = s.clock.time - planned, (s.clock.time - start) / (planned - start)
    # A push on the torso looks like a force on the foot, but stops neither end of it.
    stopped = measured.vertical_speed[foot] > -c.contact_speed
    if measured.contact[foot] > 0.5 and share >= c.early_contact_phase and stopped:
        above, rate = planned_height(s, foot)  # up at its apex it has not stopped, it turns round
        held = rate < min(-c.contact_speed, 2.0 * measured.vertical_speed[foot])
        held = held and is_near_patch(s, foot, measured.feet[foot], rate, c)
        if held or late >= 0.0 or above < c.late_contact_height:
            return True
    # A late foot that is moved down and does not go down has found the ground, whatever the forces
    # look like: to the estimator a push on the torso may hide the force on a foot.
    stays = measured.vertical_speed[foot] > -0.25 * c.reach_speed
    above = measured.feet[foot, Z] - s.swing.reference[foot, 0, Z]
    if late >= c.late_contact_wait - TIME_EPSILON and stays and above < c.late_contact_height:
        return True
    return late >= late_contact_time(s, foot, c) - TIME_EPSILON


@compiled
def late_contact_time(s: GaitState, foot: int, c: GaitConstants) -> float:
    """Return how long a late foot is waited for [s].

    Not so long that the step gets longer than `step_length` at the present speed; hardly at all
    where the robot falls meanwhile.
    """
    if s.command.flight > 0.0:
        return float(c.run_late)
    swing = s.clock.planned_touchdown[foot] - s.clock.lift_off[foot]
    speed, step = abs(s.command.velocity[0]), swing + c.double_support
    if speed * (step + c.late_contact_max) <= c.step_length:
        return float(c.late_contact_max)
    return max(c.step_length / speed - step, 0.0)


@compiled
def touch_down(
    s: GaitState, foot: int, command: Array, measured: GaitMeasurement, c: GaitConstants
) -> None:
    """Stand on a foot from now on, and learn of the ground and of the speed."""
    velocity, allowed = s.command.velocity, allowed_command(s, command, c)[0]
    steady = velocity[0] == allowed[0] and velocity[1] == allowed[1]
    count_step(s)
    take_in_foot(s, measured, foot, c)
    end_stance(s)
    if in_contact(s, 1 - foot):
        update_ground_estimate_at_touchdown(s, measured, c)
        correct_heights(s, foot)
        set_level(s, level_between(s.robot.feet[1 - foot, 2], s.robot.feet[foot, 2]))
    fit_height(s, foot, c)
    update_speed_estimate(s, bool(steady), c)
    choose_gait(s, command[3] > 0.5, c)
    if in_final_step(s):
        end_steps(s)
    elif s.command.flight > 0.0:
        land_foot(s, foot, foot, -s.command.flight)
        set_stance_anchor(s)
    else:
        shift_weight(s, foot, c)


@compiled
def shift_weight(s: GaitState, foot: int, c: GaitConstants) -> None:
    """Begin the double support after the touchdown of a foot, and say which one swings next."""
    stance, insufficient = next_stance(s, foot, weight_shift(s, c)[0], c)
    note_stance(s, insufficient, c)
    forget_footing(s)
    land_foot(s, foot, stance, weight_shift(s, c)[0])
    if stance != foot:
        clear_touchdown_history(s)
