"""What a plant is to the closed loop: ports, whichever simulator steps behind them."""

from collections.abc import Mapping
from typing import Protocol

from numpy.typing import ArrayLike
from pydrake.geometry import SceneGraph
from pydrake.systems.framework import Context, DiagramBuilder, InputPort, OutputPort, System

from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.types import Array


class Plant(Protocol):
    """A robot on its ground, in a diagram that is being built.

    Attributes:
        system: what steps, in the diagram.
        ground: its shape.
        actuation: takes torques [N m], shape (na,).
        outputs: `state` (nq + nv), and `net_actuation`, the torque of the step that led to it (na).
            Both are sampled: an update after a step sees the state behind it.
        scene_graph: what shows the robot on its ground, in the diagram; None when nobody looks.
    """

    system: System
    ground: Ground
    actuation: InputPort
    outputs: dict[str, OutputPort]
    scene_graph: SceneGraph | None

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

    def add_push(self, builder: DiagramBuilder, force: OutputPort) -> None:
        """Let a force in W [N], shape (3,), act at the torso's nominal centre of mass."""

    def prepare(self, root: Context) -> None:
        """Give a context of the diagram the masses and the damping that the scenario says."""

    def state(self, root: Context) -> Array:
        """Return the state [q, v] in a context of the diagram, shape (nq + nv,)."""

    def place(self, root: Context, x: ArrayLike) -> None:
        """Put the robot into a state [q, v], shape (nq + nv,)."""
