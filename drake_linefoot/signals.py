"""What travels between blocks: each signal's parts, with shapes, units, frames and meaning.

Conventions: world frame W with z up, torso B, contact frame C (origin in the middle of a foot's
contact, x from heel to toe, y level, or of a sole its own axes). Left before right. Of a contact
wrench, ``[f_x, f_y, f_z]`` in W and ``[tau_y, tau_z, tau_x]`` in C, on the robot at C, there are
the first nw numbers, see `contact.contacts`. SI units, radians.
"""

from typing import Annotated, Any, Final, NamedTuple

from drake_linefoot.axes import (
    COMMAND,
    COMMAND_UNITS,
    CUBIC,
    E_UNITS,
    ENDS,
    ENDS_OF_FEET,
    FEET,
    IMU,
    LINE,
    PIECE,
    PLACE,
    PLACE_UNITS,
    POSE,
    SIGMA,
    SPATIAL,
    STATE_UNITS,
    STATES,
    SWING,
    SWING_NUMBERS,
    XYZ,
)  # fmt: skip
from drake_linefoot.layout import Layout, Part, Sizes, filler, opener
from drake_linefoot.parts import (
    ACCELERATION,
    ACTIVE_ROWS,
    AT_KNOTS,
    COMING,
    EXTERNAL,
    FOOTHOLDS,
    FRAMES,
    FRICTION,
    KNOTS,
    LINES,
    OF_GROUND,
    PHASES,
    PIECES,
    SLOPE,
    STATUS,
    TIMES,
    in_world,
    spatial,
    whole,
    wrenches,
)  # fmt: skip
from drake_linefoot.statuses import Solved
from drake_linefoot.types import Array


class RobotDynamics(NamedTuple):
    """What the controller needs to know of one state; not to be changed.

    The equation of motion is ``M vdot + Cv = tau_g + S' tau + sum J_i' w_i``, (1). C is the middle
    of a foot's contact; frame C of a line has x along it, y level, z up: of a flat foot on level
    ground z is the normal, whatever the roll of the leg about the line. A sole has its own axes.
    """

    q: Annotated[Array, Part("positions", "m, rad", "nv + 1", frame="W, joints")]
    v: Annotated[Array, Part("velocities", "m/s, rad/s", "nv", frame="W, joints")]
    M: Annotated[Array, Part("mass matrix with reflected inertias", "kg m^2, kg m, kg", "nv", "nv")]
    Cv: Annotated[Array, Part("Coriolis and centrifugal forces", "N m, N", "nv")]
    tau_g: Annotated[Array, Part("generalized gravity forces", "N m, N", "nv")]
    CTv: Annotated[Array, Part("C' v; M's rate is C + C'", "N m, N", "nv")]
    R_WB: Annotated[Array, in_world("torso orientation", "-", XYZ, XYZ)]
    p_WG: Annotated[Array, in_world("centre of mass", "m", XYZ)]
    v_WG: Annotated[Array, in_world("its velocity", "m/s", XYZ)]
    A: Annotated[Array, in_world("centroidal momentum matrix about G", "kg m^2, kg", SPATIAL, "nv")]
    Adot_v: Annotated[Array, spatial("rate of that momentum at vdot = 0", ("N m", "N"))]
    p_WC: Annotated[Array, in_world("middle of each contact line", "m", FEET, XYZ)]
    R_WC: Annotated[Array, in_world("contact frames", "-", FEET, XYZ, XYZ)]
    v_WC: Annotated[Array, in_world("velocity of the middles", "m/s", FEET, XYZ)]
    w_WF: Annotated[Array, in_world("angular velocity of the feet", "rad/s", FEET, XYZ)]
    J: Annotated[Array, Part("contact Jacobians (51)", "-", FEET, "nw", "nv")]
    Jdot_v: Annotated[Array, Part("bias of these rows", "m/s^2, rad/s^2", FEET, "nw")]

    @property
    def p_WB(self) -> Array:
        """Torso origin [m], shape (3,)."""
        return self.q[4:7]

    @property
    def L_G(self) -> Array:
        """Angular momentum about the CoM [kg m^2/s], shape (3,)."""
        return self.A[:3] @ self.v


class SwingTarget(NamedTuple):
    """Where the contact line of a swing foot should be now."""

    p_WC: Annotated[Array, in_world("middle of the line", "m", XYZ)]
    v_WC: Annotated[Array, in_world("its velocity", "m/s", XYZ)]
    a_WC: Annotated[Array, in_world("its acceleration", "m/s^2", XYZ)]
    d_W: Annotated[Array, in_world("unit vector from heel to toe", "-", XYZ)]
    w_W: Annotated[Array, in_world("angular velocity of the line", "rad/s", XYZ)]
    alpha_W: Annotated[Array, in_world("angular acceleration", "rad/s^2", XYZ)]


class GaitTargets(NamedTuple):
    """What holds now, every tick; target and foothold of a foot that does not swing are zero."""

    time: Annotated[float, Part("when it holds", "s")]
    contact: Annotated[Array, whole("1 for a foot that stands, else 0", FEET)]
    touchdown: Annotated[Array, Part("last, or next: of one that swings or waits", "s", FEET)]
    queued: Annotated[float, whole("steps to follow; 1e9: no end, 0: it is to stand")]
    swings: Annotated[Array, whole("1 for a foot that swings, else 0", FEET)]
    swing: Annotated[Array, in_world("rows of `SwingTarget`", "m, rad, s", FEET, SWING, XYZ)]
    foothold: Annotated[Array, Part("where it will land", PLACE_UNITS, FEET, PLACE, frame="W")]
    command: Annotated[Array, Part("after rate limits", COMMAND_UNITS, COMMAND)]
    yaw: Annotated[float, Part("desired heading", "rad", frame="W")]
    slope: Annotated[Array, in_world(OF_GROUND, "-", FEET, ("x", "y"))]
    friction: Annotated[float, FRICTION]
    friction_share: Annotated[Array, Part("little where nothing is borne", "-", FEET, ENDS)]
    external: Annotated[Array, EXTERNAL]
    arms: Annotated[Array, Part("of shoulders, two derivatives, see `arm_motion`", "rad, s", 3)]
    limited: Annotated[float, whole("why the command is another: a `Limit`")]
    steps: Annotated[float, whole("steps taken")]
    moved_footholds: Annotated[float, whole("ticks in which a limit moved the foothold")]
    clipped_commands: Annotated[float, whole("ticks in which the command was clipped")]

    def swing_target(self, side: int) -> SwingTarget:
        """The rows of `swing` of a foot by name."""
        return SwingTarget(*self.swing[side])


class ContactEstimate(NamedTuple):
    """Output of the contact estimator."""

    wrench: Annotated[Array, wrenches("estimated wrench")]
    contact: Annotated[Array, whole("1 for a foot on the ground, else 0", FEET)]
    residual: Annotated[Array, Part("tau_d of (21), of all contacts", "N m, N", "nv")]
    external: Annotated[Array, EXTERNAL]


class StateEstimate(NamedTuple):
    """Output of the state estimator, beside the state."""

    pose: Annotated[Array, Part("R_WB as a quaternion, p_WB", ("-", "m"), POSE, groups=(4, 3))]
    velocity: Annotated[Array, spatial("w_WB, v_WB", ("rad/s", "m/s"))]
    sigma: Annotated[Array, Part("deviations", ("rad", "m/s", "m"), SIGMA, groups=(3, 3, 3))]
    biases: Annotated[
        Array, Part("of both sensors", ("rad/s", "m/s^2"), IMU, groups=(3, 3), frame="B")
    ]
    innovation: Annotated[Array, Part("of each heel and toe that has one", "m", ENDS_OF_FEET, XYZ)]
    nis: Annotated[Array, Part("squared Mahalanobis distance of it", "-", ENDS_OF_FEET)]
    measured: Annotated[Array, whole("1 for a heel or toe that has one, else 0", ENDS_OF_FEET)]
    stands: Annotated[Array, whole("1 for one that stands on the ground, else 0", ENDS_OF_FEET)]
    refused: Annotated[float, whole("innovations outside the gate so far")]
    slips: Annotated[float, whole("points that had to hold anew so far")]


class GaitHorizon(NamedTuple):
    """What is planned from now on, as far as the MPC looks.

    A phase is an interval in which the same feet stand; the first contains the present. Of those
    that are not there all is zero, as it is of the swing of a foot that stands.
    """

    time: Annotated[float, Part("now", "s")]
    phases: Annotated[float, whole("how many phases there are")]
    ends: Annotated[Array, Part("begin and end of each phase", "s", PHASES, ("begin", "end"))]
    contact: Annotated[Array, whole("1 for a foot that stands in it, else 0", PHASES, FEET)]
    slopes: Annotated[Array, in_world(OF_GROUND, "-", PHASES, FEET, ("x", "y"))]
    feet: Annotated[Array, Part("contact lines; where a swing ends", "m, rad", PHASES, FEET, PLACE)]
    swing: Annotated[Array, Part("of a `Swing`", "s, m, rad", PHASES, FEET, SWING_NUMBERS)]
    reference: Annotated[Array, Part("now, two derivatives", "m, rad, s", PHASES, FEET, 3, LINE)]
    target: Annotated[Array, Part("where it comes to rest", "m, rad", PHASES, FEET, LINE)]
    pieces: Annotated[float, whole("how many pieces of the DCM there are")]
    dcm: Annotated[
        Array, Part("centre + amplitude exp(rate (t - begin))", "s, m, 1/s", PIECES, PIECE)
    ]
    rise: Annotated[Array, Part("CoM over `com_height`, by t - begin", "m, s", PIECES, CUBIC)]
    coming: Annotated[float, COMING]
    footholds: Annotated[Array, FOOTHOLDS]
    yaw: Annotated[float, Part("desired heading now", "rad", frame="W")]
    turn_rate: Annotated[float, Part("desired turn rate", "rad/s", frame="W")]
    omega: Annotated[float, Part("natural frequency of the pendulum", "1/s")]
    com_height: Annotated[float, Part("desired height of the CoM above the ground", "m")]
    ground: Annotated[Array, in_world("a point of it, where a foot stands", "m", XYZ)]
    slope: Annotated[Array, SLOPE]
    friction: Annotated[float, FRICTION]
    external: Annotated[Array, EXTERNAL]
    lean: Annotated[Array, in_world("from the CoM to that of the pendulum", "m", ("x", "y"))]
    arm_swing: Annotated[float, Part("of the shoulders, see `arm_motion`", "rad/m")]


class Reference(NamedTuple):
    """Reference of the MPC over its intervals between knots: x_H* of (40)."""

    times: Annotated[Array, TIMES]
    r: Annotated[Array, in_world("CoM at the knots", "m", AT_KNOTS, XYZ)]
    v: Annotated[Array, in_world("its velocity there", "m/s", AT_KNOTS, XYZ)]
    R: Annotated[Array, in_world("torso orientation there", "-", AT_KNOTS, XYZ, XYZ)]
    L: Annotated[Array, in_world("angular momentum about the CoM there", "kg m^2/s", AT_KNOTS, XYZ)]
    r_mid: Annotated[Array, in_world("CoM in the middle of each interval", "m", "knots", XYZ)]
    v_mid: Annotated[Array, in_world("its velocity there", "m/s", "knots", XYZ)]
    R_mid: Annotated[Array, in_world("torso orientation there", "-", "knots", XYZ, XYZ)]
    Omega_mid: Annotated[Array, Part("its angular velocity", "rad/s", "knots", XYZ, frame="B")]
    L_mid: Annotated[Array, in_world("angular momentum there", "kg m^2/s", "knots", XYZ)]
    I_B: Annotated[Array, Part("locked inertia there", "kg m^2", "knots", XYZ, XYZ, frame="B")]
    E: Annotated[Array, Part("torso rate of L and m r'; or 0", E_UNITS, "knots", XYZ, 6, frame="B")]
    contact: Annotated[Array, whole("1 for a foot that stands, else 0", "knots", FEET)]
    p_WC: Annotated[Array, LINES]
    R_WC: Annotated[Array, FRAMES]
    slope: Annotated[Array, in_world(OF_GROUND, "-", "knots", FEET, ("x", "y"))]
    friction: Annotated[float, FRICTION]
    external: Annotated[Array, EXTERNAL]
    reach_error: Annotated[float, Part("largest residual of the inverse kinematics", "m, rad")]
    coming: Annotated[float, COMING]
    footholds: Annotated[Array, FOOTHOLDS]

    @property
    def dt(self) -> Array:
        """Lengths of the intervals [s], shape (knots,)."""
        return self.times[1:] - self.times[:-1]


class CentroidalPlan(NamedTuple):
    """What the MPC decided: wrenches that are constant in each interval, and the motion."""

    times: Annotated[Array, TIMES]
    wrench: Annotated[Array, wrenches("of each foot", "knots")]
    force: Annotated[Array, in_world("of both feet", "N", "knots", XYZ)]
    moment: Annotated[Array, in_world("of both feet about r_G", "N m", "knots", XYZ)]
    states: Annotated[
        Array, Part("[r, r', L_G, eta] of (36)", STATE_UNITS, AT_KNOTS, STATES, groups=(3, 3, 3, 3))
    ]
    r_G: Annotated[Array, in_world("the fixed point of L_G", "m", XYZ)]
    mass: Annotated[float, Part("of the robot", "kg")]
    p_WC: Annotated[Array, LINES]
    R_WC: Annotated[Array, FRAMES]
    coming: Annotated[float, COMING]
    footholds: Annotated[Array, FOOTHOLDS]
    external: Annotated[Array, EXTERNAL]
    status: Annotated[float, STATUS]
    active: Annotated[float, ACTIVE_ROWS]
    iterations: Annotated[float, whole("of the solver")]
    milliseconds: Annotated[float, Part("wall time of the update", "ms")]
    failures: Annotated[float, whole("programs that were not solved so far")]

    @property
    def success(self) -> bool:
        """Whether the last program was solved; else the plan is the one before it."""
        return Solved(int(self.status)).success


class WholeBodyReport(NamedTuple):
    """What the whole-body controller did in one tick."""

    torque: Annotated[Array, Part("after limits", "N m", "na")]
    wrench: Annotated[Array, wrenches("it counts on")]
    wrench_error: Annotated[Array, wrenches("correction of the MPC's, delta_fr of (49)")]
    acceleration_error: Annotated[Array, spatial("that of the base, delta_f of (49)", ACCELERATION)]
    vdot: Annotated[Array, Part("generalized acceleration it counts on", "m/s^2, rad/s^2", "nv")]
    status: Annotated[float, STATUS]
    active: Annotated[float, ACTIVE_ROWS]
    dropped_rows: Annotated[float, whole("task rows that contradict a higher task")]
    clipped: Annotated[float, whole("torques that had to be limited")]
    milliseconds: Annotated[float, Part("wall time of the tick", "ms")]

    @property
    def success(self) -> bool:
        """Whether the wrench program was solved."""
        return Solved(int(self.status)).success


SIGNALS: Final[dict[str, type[Any]]] = {  # by the name of the ports
    "dynamics": RobotDynamics,
    "contact": ContactEstimate,
    "targets": GaitTargets,
    "horizon": GaitHorizon,
    "reference": Reference,
    "plan": CentroidalPlan,
    "report": WholeBodyReport,
    "estimate": StateEstimate,
}


def layouts(sizes: Sizes, knots: int = KNOTS) -> dict[str, Layout[Any]]:
    """Return how each of `SIGNALS` travels; `sizes` are "nq", "nv", "na" and "nw" of the robot."""
    every = {**sizes, "knots": knots}
    return {name: Layout(signal, every) for name, signal in SIGNALS.items()}


open_dynamics = opener(RobotDynamics, "nv", "nw")
open_contact = opener(ContactEstimate, "nv", "nw")
open_targets, fill_targets = opener(GaitTargets), filler(GaitTargets)
open_plan, open_reference = opener(CentroidalPlan, "knots", "nw"), opener(Reference, "knots")
fill_report = filler(WholeBodyReport, "na", "nv", "nw")
open_horizon, fill_horizon = opener(GaitHorizon, "knots"), filler(GaitHorizon, "knots")
