"""What a task is: rows ``J vdot = b`` with a place in the order of priority."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar, Final, NamedTuple

import numpy as np

from drake_linefoot.errors import InputError
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import GaitTargets, RobotDynamics
from drake_linefoot.types import Array, Indices

# Priorities of the tasks of this package; a smaller number comes first.
CONTACT: Final = 0.0
MOMENTUM: Final = 10.0
SWING: Final = 20.0
POSTURE: Final = 30.0


class TaskRows(NamedTuple):
    """A task ``J vdot = b``.

    Attributes:
        J: Jacobian, shape (m, nv).
        b: desired acceleration minus the bias Jdot v, shape (m,).
    """

    J: Array
    b: Array


class Gains(NamedTuple):
    """Gains of the tasks, see `WbcParameters`.

    Attributes:
        com_position: K_P,r of (52) [1/s^2].
        com_velocity: K_D,r of (52) [1/s].
        angular_momentum: K_P,L of (53) [1/s].
        swing_position: of the swing foot [1/s^2].
        swing_velocity: of the swing foot [1/s].
        joint_position: of the arms [1/s^2].
        joint_velocity: of the arms [1/s].
        contact_velocity: damping of standing feet [1/s].
    """

    com_position: float
    com_velocity: float
    angular_momentum: float
    swing_position: float
    swing_velocity: float
    joint_position: float
    joint_velocity: float
    contact_velocity: float


class Task(ABC):
    """A task of one's own, for `build_controller(tasks=...)`.

    Attributes:
        name: in messages; not twice in a controller.
        priority: where it comes in the order: before the tasks of this package whose priority is
            larger, `CONTACT`, `MOMENTUM`, `SWING`, `POSTURE`. One that leaves no freedom to those
            below it takes it from them: the robot may fall.
        joints: names of actuated joints that it decides, and the posture leaves to it.
    """

    name: str
    priority: float
    joints: ClassVar[Sequence[str]] = ()

    @abstractmethod
    def rows(self, d: RobotDynamics, targets: GaitTargets) -> TaskRows:
        """Return what it asks for now; always as many rows.

        Args:
            d: quantities of the present state.
            targets: which feet stand, and where the others are to be.
        """


def own_rows(tasks: Sequence[Task], d: RobotDynamics, targets: GaitTargets) -> Array:
    """Return the rows of one's own tasks, in the order of their priority.

    Args:
        tasks: sorted by priority.
        d: quantities of the present state.
        targets: of the gait.

    Returns:
        J beside b and the priority, shape (m, nv + 2).

    Raises:
        InputError: rows of a task do not fit the robot, or are not finite.
    """
    nv, every = len(d.v), [np.empty((0, len(d.v) + 2))]
    for task in tasks:
        J, b = (np.asarray(part, dtype=float) for part in task.rows(d, targets))
        if J.ndim != 2 or J.shape != (len(b), nv):
            allowed = f"J must have shape (m, {nv}) and b (m,)"
            raise InputError("task", task.name, (J.shape, b.shape), allowed)
        if not (np.isfinite(J).all() and np.isfinite(b).all()):
            raise InputError("task", task.name, "J or b", "must be finite")
        every.append(np.column_stack([J, b, np.full(len(b), float(task.priority))]))
    return np.concatenate(every)


def arms_left(humanoid: Humanoid, tasks: Sequence[Task]) -> Indices:
    """Return which of the arm joints no task of one's own decides: places among them.

    Raises:
        InputError: two tasks have one name; a joint is not of the arms.
    """
    names = [humanoid.description.actuated_joints[i] for i in humanoid.arm_joints]
    seen, own = set[str](), set[str]()
    for task in tasks:
        if task.name in seen:
            raise InputError("task", task.name, "name", "another task has it")
        if unknown := set(task.joints) - set(names):
            allowed = f"must be of the arms: {names}"
            raise InputError("task", task.name, sorted(unknown), allowed)
        seen.add(task.name)
        own |= set(task.joints)
    return np.array([i for i, name in enumerate(names) if name not in own], dtype=int)
