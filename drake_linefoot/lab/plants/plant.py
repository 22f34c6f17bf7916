"""What a plant is to the closed loop: ports, whichever simulator steps behind them."""

from collections.abc import Mapping
from typing import Protocol

from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort

from drake_linefoot.lab.simulation.ground import Ground


class Plant(Protocol):
    """A robot on its ground, in a diagram that is being built.

    Attributes:
        ground: its shape.
        actuation: takes torques [N m], shape (na,).
        forces: takes what pushes the robot.
        outputs: `state` (nq + nv), and `net_actuation`, the torque of the step that led to it (na).
            Both are sampled: an update after a step sees the state behind it.
    """

    ground: Ground
    actuation: InputPort
    forces: InputPort
    outputs: dict[str, OutputPort]

    def add_imu(self, builder: DiagramBuilder) -> dict[str, OutputPort]:
        """Add an IMU in the base; return `angular_velocity` and `specific_force` in B, (3,)."""

    def add_contacts(
        self, builder: DiagramBuilder, sources: Mapping[str, OutputPort]
    ) -> OutputPort:
        """Add what says how the feet touch the ground; return `foot_contacts`.

        Args:
            builder: of the diagram.
            sources: by their names; it may take `dynamics`.
        """
