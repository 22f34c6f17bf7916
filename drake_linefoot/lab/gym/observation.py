"""What a policy sees of the robot: a vector whose entries have names, units and bounds."""

from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context

from drake_linefoot.axes import COMMAND, COMMAND_UNITS, FEET, XYZ
from drake_linefoot.layout import Layout
from drake_linefoot.leaf_system import Block, read_finite, read_signal, weak
from drake_linefoot.math.rotation import from_quaternion, roll_pitch_yaw
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import GaitTargets
from drake_linefoot.types import Array

FAST, QUICK = 10.0, 50.0  # [m/s], [rad/s] beyond which a number is cut


class Entry(NamedTuple):
    """One number of an observation."""

    name: str
    unit: str
    most: float  # in size; what is beyond is cut


def entries_of(humanoid: Humanoid) -> list[Entry]:
    """Return what an observation consists of, in order."""
    joints = humanoid.description.actuated_joints
    reach = np.maximum(np.abs(humanoid.position_lower), np.abs(humanoid.position_upper)) + 0.5
    return [
        Entry("height", "m", 10.0 * humanoid.com_height),
        *(Entry(f"up_{axis}", "-", 1.0) for axis in XYZ),
        *(Entry(f"angular_{axis}", "rad/s", QUICK) for axis in XYZ),
        *(Entry(f"velocity_{axis}", "m/s", FAST) for axis in XYZ),
        *(Entry(joint, "rad", float(r)) for joint, r in zip(joints, reach, strict=True)),
        *(
            Entry(f"{joint}_rate", "rad/s", 2.0 * float(speed))
            for joint, speed in zip(joints, humanoid.velocity_limits, strict=True)
        ),
        *(Entry(f"{foot}_stands", "-", 1.0) for foot in FEET),
        *(
            Entry(f"goal_{name}", unit, FAST)
            for name, unit in zip(COMMAND, COMMAND_UNITS, strict=True)
        ),
    ]


class Observation(Block):
    """Makes an observation of the state.

    .. pydrake_system::

        name: Observation
        input_ports:
        - state
        - targets
        output_ports:
        - observation

    Height of the torso; up, angular velocity and velocity in the torso's frame B; joints; which
    feet the gait has standing; the velocity that is the goal, a parameter of the Context.
    """

    def __init__(self, humanoid: Humanoid) -> None:
        super().__init__()
        self.set_name("observation")
        self._robot, self._most = humanoid, np.array([e.most for e in entries_of(humanoid)])
        self.DeclareNumericParameter(BasicVector(np.zeros(3)))
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + humanoid.nv)
        self._of_targets = Layout(GaitTargets, {})
        self._targets = self.signal_input("targets", self._of_targets)
        tickets = {self._state.ticket(), self._targets.ticket(), self.all_parameters_ticket()}
        size, calc = len(self._most), weak(self, self._calc)
        self.DeclareVectorOutputPort("observation", size, calc, prerequisites_of_calc=tickets)

    def _calc(self, context: Context, output: BasicVector) -> None:
        robot, x = self._robot, read_finite(self, self._state, context)
        targets = read_signal(self, self._targets, context, self._of_targets)
        q, v = x[: robot.nq], x[robot.nq :]
        R_BW = from_quaternion(q[:4]).T
        numbers = [
            q[6:7],
            R_BW[:, 2],
            R_BW @ v[:3],
            R_BW @ v[3:6],
            q[robot.actuated_q],
            v[robot.actuated_v],
            targets.contact,
            context.get_numeric_parameter(0).value(),
        ]
        output.SetFromVector(np.clip(np.concatenate(numbers), -self._most, self._most))


def tilt_of(q: Array) -> float:
    """Return the larger of roll and pitch of the torso [rad] in positions, shape (nq,)."""
    return float(np.abs(roll_pitch_yaw(q[:4])[:2]).max())
