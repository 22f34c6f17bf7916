"""Postures with flat soles: where a robot stands, and how far its legs reach."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.mirror import joint_lines
from drake_linefoot.robot.scaling import INSIDE
from drake_linefoot.robot.standing import standing_torques
from drake_linefoot.types import Array

BENT = 0.93  # [-] of the straight robot's CoM height, in the posture; the MIT Humanoid's
LEAST_BENT = 0.97  # [-] where knees are weak
NEARLY_STRAIGHT = (0.965, 0.97, 0.975, 0.98, 0.985)  # [-] in a walk where a joint turns too little
MOST_STRAIGHT = 0.985  # [-] of a posture
WALKING = 0.984  # [-] of the posture's, CoM height of a walk by default
TORQUE_SHARE = 0.7  # [-] of a knee's limit that standing on one leg may take
RESIDUAL = 2e-3  # [m, rad] up to which a posture is reached
MARGIN = 0.02  # [rad] that postures keep from joint stops
CLEARANCE = 0.03  # [-] of the height, between feet side by side
BACK, AHEAD = 0.4, 0.6  # [-] of a step: of the CoM behind, of the landing foot ahead
_GAIT = GaitParameters()
STRIDE = _GAIT.step_length / _GAIT.com_height  # [-] of the CoM height, of a walk by default
LIFT = _GAIT.swing_height / _GAIT.com_height  # [-] likewise: apex of a swing
# Where a foot is in a step, ahead of the CoM by the step, and above the ground by the apex: as it
# stands, and as it swings, after a sixth, a quarter, a third, a half and two thirds of the time.
STANDS = ((AHEAD, 0.0), (-BACK, 0.0))
SWINGS = ((-0.5, 0.13), (-0.44, 0.42), (-0.28, 0.75), (0.1, 1.0), (0.48, 0.75))
SWINGING = 0.5  # [-] of the longest step, in which the swing has room
OFF_SWING = 0.01  # [m, rad] by which a foot may be off there, in the air
SHARES = (1.0, 0.8, 0.6, 0.45, 0.3)  # [-] of a stride and of a lift that are tried


@dataclass(frozen=True)
class Reach:
    """What legs can do, lengths in m.

    Attributes:
        q: configuration of the nominal posture, shape (nq,).
        height: CoM above the soles there.
        straight: with the straightest legs.
        lowest: with the most bent.
        width: between the feet.
        walking: CoM above the soles in a walk by default.
        room: shares of the stride and of the lift of a walk by default for which no joint comes
            to a stop, of `SHARES`, or 0 for none [-].
    """

    q: Array
    height: float
    straight: float
    lowest: float
    width: float
    walking: float
    room: tuple[float, float]


def place_feet(humanoid: Humanoid, q: Array, p_BC: Array) -> tuple[Array, float]:
    """Return a configuration with level feet ahead at two places, and how far it is off.

    It starts from q, torso upright, shape (nq,); the middles p_BC are in B [m], shape (2, 3); the
    residual is that of the worse foot [m, rad].
    """
    worst, found = 0.0, q.copy()
    for side in range(2):
        lower, upper = leg_limits(humanoid, side)
        start = np.clip(q[humanoid.leg_q[side]], lower + 1e-6, upper - 1e-6)

        def off(angles: Array, side: int = side) -> Array:
            found[humanoid.leg_q[side]] = angles
            p, R = foot_of(humanoid, found, side)
            turned = np.array([R[1, 0], R[2, 0], R[2, 1]])  # in yaw, pitch and roll
            return np.concatenate([p - p_BC[side], turned[: humanoid.contact.size - 3]])

        solution = least_squares(off, start, bounds=(lower, upper), xtol=1e-10, ftol=1e-10)
        found[humanoid.leg_q[side]] = solution.x
        worst = max(worst, float(np.abs(solution.fun).max()))
    return found, worst


def leg_limits(humanoid: Humanoid, side: int) -> tuple[Array, Array]:
    """Return bounds of a leg's angles, a little inside stops of both legs [rad], shapes (n,)."""
    joints, stops = humanoid.leg_joints[side], (humanoid.position_lower, humanoid.position_upper)
    images = np.sort([humanoid.mirror_joints(stop) for stop in stops], axis=0)
    lower = np.maximum(stops[0], images[0])[joints]
    upper = np.minimum(stops[1], images[1])[joints]
    margin = np.minimum(MARGIN, 0.1 * (upper - lower))
    return lower + margin, upper - margin


def foot_of(humanoid: Humanoid, q: Array, side: int) -> tuple[Array, Array]:
    """Return the middle of a contact [m] and the axes of its foot in B, shapes (3,) and (3, 3)."""
    humanoid.plant.SetPositions(humanoid.scratch, q)
    X = humanoid.foot_frames[side].CalcPose(humanoid.scratch, humanoid.base.body_frame())
    return X @ humanoid.p_FC[side], X.rotation().matrix()


def com_in_base(humanoid: Humanoid, q: Array) -> Array:
    """Return the CoM in B with the torso upright at the origin [m], shape (3,)."""
    humanoid.plant.SetPositions(humanoid.scratch, q)
    return humanoid.floating.com(humanoid.scratch)


def under_com(humanoid: Humanoid, q: Array, height: float, width: float) -> tuple[Array, float]:
    """Return a configuration with feet so far below the CoM and apart [m], see `place_feet`."""
    residual = np.inf
    for _ in range(8):  # the CoM moves with the legs
        com = com_in_base(humanoid, q)
        p_BC = com + np.array([[0.0, 0.5 * width, -height], [0.0, -0.5 * width, -height]])
        q, residual = place_feet(humanoid, q, p_BC)
        if np.abs(com_in_base(humanoid, q) - com).max() < 1e-6:
            break
    mirrored = humanoid.mirror_state(np.concatenate([q, np.zeros(humanoid.nv)]))[: humanoid.nq]
    q[humanoid.leg_q[1]] = mirrored[humanoid.leg_q[1]]
    return q, residual


def find_reach(humanoid: Humanoid, sole_width: float) -> Reach:
    """Return the nominal posture and between which heights legs can stand.

    From legs that are bent a little, the CoM is lowered and raised as far as it goes; the posture
    is bent as the MIT Humanoid's, and less where the knees are too weak for that.

    Raises:
        ValueError: no height has flat soles under the CoM.
    """
    rest = np.zeros(humanoid.nq)
    rest[0] = 1.0
    rest[humanoid.actuated_q] = np.clip(0.0, humanoid.position_lower, humanoid.position_upper)
    spread = foot_of(humanoid, rest, 0)[0] - foot_of(humanoid, rest, 1)[0]
    com = com_in_base(humanoid, rest)
    tall = float(com[2] - foot_of(humanoid, rest, 0)[0][2])
    width = max(float(abs(spread[1])), sole_width + 0.05 * tall)
    postures: list[tuple[float, Array]] = []
    for bend in bent_starts(humanoid, rest):
        found = _heights(humanoid, bend, tall, width)
        if _range(found) > 1.1 * _range(postures):
            postures = found
    if not postures:
        raise ValueError("no posture has flat soles under the centre of mass")
    return _posture(humanoid, postures, width)


def _posture(humanoid: Humanoid, postures: list[tuple[float, Array]], width: float) -> Reach:
    """Return the most bent posture that is strong and has room for a walk, or what comes nearest.

    Args:
        humanoid: the robot.
        postures: heights of the CoM, ascending [m], each with a configuration.
        width: between the feet [m].
    """
    lowest, straight = postures[0][0], postures[-1][0]
    tried: list[tuple[float, float, Reach]] = []
    shares = [(share, WALKING * share) for share in np.linspace(BENT, LEAST_BENT, 5).tolist()]
    shares += [(min(share / WALKING, MOST_STRAIGHT), share) for share in NEARLY_STRAIGHT]
    for share, in_walk in shares:
        if share > LEAST_BENT and any(room == 1.0 for room, _, _ in tried):
            break
        height = max(share * straight, lowest)
        _, q = min(postures, key=lambda each: abs(each[0] - share * straight))
        q, _ = under_com(humanoid, q, height, width)
        strong = knee_share(humanoid, q) < TORQUE_SHARE
        above = min(1.02 * lowest, NEARLY_STRAIGHT[-1] * straight)
        walking = max(WALKING * height, in_walk * straight, above)
        room = find_room(humanoid, q, walking, width)
        found = Reach(q, height, straight, lowest, width, walking, room)
        if strong and room == (1.0, 1.0):
            return found
        tried.append((room[0] * room[1], in_walk, found))
    return max(tried, key=lambda each: each[:2])[2]


def find_room(humanoid: Humanoid, q: Array, height: float, width: float) -> tuple[float, float]:
    """Return for how long a step, and for how high a swing in it, no joint comes to a stop.

    Args:
        humanoid: the robot.
        q: upright with flat soles, shape (nq,).
        height: of the CoM in a walk [m].
        width: between the feet [m].

    Returns:
        Shares of the stride and of the lift of a walk by default, of `SHARES`, or 0 [-].
    """
    com, stride, lift = com_in_base(humanoid, q), STRIDE * height, LIFT * height

    def fits(places: Sequence[tuple[float, float]], step: float, apex: float, off: float) -> bool:
        for ahead, up in places:
            p = np.array([ahead * step, 0.0, up * apex - height])
            aside = np.array([[0.0, 0.5 * width, 0.0], [0.0, -0.5 * width, 0.0]])
            if place_feet(humanoid, q, com + p + aside)[1] > off:
                return False
        return True

    long = next((s for s in SHARES if fits(STANDS, s * stride, 0.0, RESIDUAL)), 0.0)
    step = min(long, SWINGING) * stride
    return long, next((s for s in SHARES if fits(SWINGS, step, s * lift, OFF_SWING)), 0.0)


def bent_starts(humanoid: Humanoid, rest: Array) -> list[Array]:
    """Return configurations with knees bent ahead, as people's are, and behind."""
    base, starts = humanoid.base.body_frame(), []
    for bend in (0.3, -0.3):
        q = rest.copy()
        for side in range(2):
            _, axes = joint_lines(humanoid.names, base, humanoid.description.feet[side].leg_joints)
            pitch = [i for i in range(len(axes)) if abs(axes[i, 1]) > 0.7]
            hip, knee, ankle = pitch[0], pitch[len(pitch) // 2], pitch[-1]
            for i, angle in ((hip, -bend), (knee, 2.0 * bend), (ankle, -bend)):
                q[humanoid.leg_q[side, i]] += angle * np.sign(axes[i, 1])
            lower, upper = leg_limits(humanoid, side)
            q[humanoid.leg_q[side]] = np.clip(q[humanoid.leg_q[side]], lower, upper)
        starts.append(q)
    return starts


def _range(postures: list[tuple[float, Array]]) -> float:
    return postures[-1][0] - postures[0][0] if postures else 0.0


def _heights(humanoid: Humanoid, q: Array, tall: float, width: float) -> list[tuple[float, Array]]:
    """Return heights of the CoM that can be stood at, ascending [m], each with a posture."""
    height = float(com_in_base(humanoid, q)[2] - foot_of(humanoid, q, 0)[0][2])
    q, residual = under_com(humanoid, q, height, width)
    if residual > RESIDUAL:
        return []
    found = [(height, q)]
    for way in (-1.0, 1.0):
        at, posture, step = height, q, 0.02 * tall
        while step > 1e-3 * tall and at > 0.4 * tall:
            bent, residual = under_com(humanoid, posture, at + way * step, width)
            if residual > RESIDUAL:
                step *= 0.5
                continue
            at, posture = at + way * step, bent
            found.append((at, posture))
    return sorted(found, key=lambda each: each[0])


def knee_share(humanoid: Humanoid, q: Array) -> float:
    """Return the largest share of a leg joint's torque limit that standing on one leg takes."""
    torques = np.abs(standing_torques(humanoid, q)[1])
    return float((torques / humanoid.effort_limits[humanoid.leg_joints]).max())


def step_limits(humanoid: Humanoid, reach: Reach, sole_width: float) -> dict[str, float]:
    """Return what the gait may ask of the legs, the fields of `StepLimits` [m]."""
    h, walking = reach.height, reach.walking
    com = com_in_base(humanoid, reach.q)

    def off(ahead: Array, across: float, height: float) -> float:
        p = np.column_stack([ahead, [0.5 * across, -0.5 * across], [-height, -height]])
        return place_feet(humanoid, reach.q, com + p)[1]

    def step(length: float) -> bool:
        ahead = np.array([AHEAD, -BACK]) * length
        return off(ahead, reach.width, walking) < RESIDUAL

    lowest, highest = min(1.01 * reach.lowest, 0.98 * walking), 0.0
    if walking > 1.001 * WALKING * h:  # `scaled` puts a walk by default between both
        highest = min(INSIDE * walking, reach.straight)
        lowest = 2.0 * walking - highest
    widest = _largest(lambda w: off(np.zeros(2), w, walking) < RESIDUAL, reach.width, 0.69 * h)
    limits = {
        "step_length": _largest(step, 0.05 * h, 0.78 * h),
        "step_width_min": min(sole_width + CLEARANCE * h, 0.95 * reach.width),
        "step_width_max": max(widest, 1.05 * reach.width),
        "com_height_min": lowest,
        "com_height_max": max(0.97 * reach.straight, 1.005 * h, highest),
    }
    lift = max(reach.room[1], SHARES[-1])
    return limits if lift == 1.0 else {**limits, "swing_height_max": lift * LIFT * walking}


def _largest(fits: Callable[[float], bool], low: float, high: float) -> float:
    """Return the largest number that fits, from bisection; `low` when none is known to."""
    if fits(high):
        return high
    for _ in range(8):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low
