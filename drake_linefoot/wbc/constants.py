"""What the whole-body controller knows of its parameters and of the robot."""

from typing import Any, NamedTuple, TypeAlias

from drake_linefoot.math.compiled import inlined
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array, Indices
from drake_linefoot.wbc.held_joints import JointLimits
from drake_linefoot.wbc.joint_limits import leg_limits
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.tasks.posture import Joints
from drake_linefoot.wbc.tasks.task import Gains
from drake_linefoot.wbc.wrench_qp import Weights, wrench_weights

Packed: TypeAlias = tuple[Any, ...]  # `Constants`, with those inside as plain tuples, too


class Constants(NamedTuple):
    """What does not change from tick to tick.

    Attributes:
        mass: [kg].
        gains: of the tasks.
        arms: the joints that neither the legs nor one's own tasks decide.
        limits: of the legs.
        weights: of (49).
        actuated_v: index in v of each actuator, shape (na,).
        effort_limits: symmetric [N m], shape (na,).
    """

    mass: float
    gains: Gains
    arms: Joints
    limits: JointLimits
    weights: Weights
    actuated_v: Indices
    effort_limits: Array


@inlined
def opened(c: Packed) -> Constants:
    """Return the constants that plain tuples hold."""
    return Constants(
        c[0], Gains(*c[1]), Joints(*c[2]), JointLimits(*c[3]), Weights(*c[4]), c[5], c[6]
    )


def packed(constants: Constants) -> Packed:
    """Return constants as plain tuples."""
    return tuple(tuple(c) if isinstance(c, tuple) else c for c in constants)


def constants_of(p: WbcParameters, humanoid: Humanoid, arms: Indices, turns: Array) -> Constants:
    """Return the constants of a robot.

    Args:
        p: parameters in its size.
        humanoid: the robot.
        arms: which of its arm joints have no task of one's own.
        turns: which way its arm joints swing, see `arm_turns`.
    """
    h = humanoid
    gains = Gains(
        p.com_position_gain, p.com_velocity_gain, p.angular_momentum_gain,
        p.swing_position_gain, p.swing_velocity_gain, p.arm_position_gain,
        p.arm_velocity_gain, p.contact_velocity_gain,
    )  # fmt: skip
    return Constants(
        mass=h.mass,
        gains=Gains(*map(float, gains)),
        arms=Joints(h.arm_q[arms], h.arm_v[arms], h.q_nominal[h.arm_q[arms]], turns[arms]),
        limits=leg_limits(h, p),
        weights=wrench_weights(p, h.mass, h.contact),
        actuated_v=h.actuated_v,
        effort_limits=h.effort_limits,
    )
