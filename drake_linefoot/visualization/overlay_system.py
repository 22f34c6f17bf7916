"""The LeafSystem that draws the overlays while a loop is simulated."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.geometry import Meshcat
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.systems.framework import Context

from drake_linefoot.leaf_system import Block, read_signal, weak
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import CentroidalPlan, ContactEstimate, GaitTargets
from drake_linefoot.simulation.channels import com_ahead
from drake_linefoot.simulation.ground import Ground
from drake_linefoot.types import Array
from drake_linefoot.visualization.instant import (
    Instant,
    end_forces,
    measured_instant,
    sum_at_ends,
)
from drake_linefoot.visualization.overlays import OverlayPainter

PERIOD = 1.0 / 32.0  # [s] a power of two, so that drawings fall on frames of the recording
SIGNALS = {"contact": ContactEstimate, "targets": GaitTargets, "plan": CentroidalPlan}


class Overlays(Block):
    """Draws contact forces, footholds, plans and the centre of mass into Meshcat.

    | port | type | shape | unit |
    |---|---|---|---|
    | state | vector | nq + nv | Drake's order |
    | contact_results | ContactResults | - | of the plant |
    | contact | ContactEstimate | - | optional; estimated forces |
    | targets | GaitTargets | - | optional; which feet stand, swing target |
    | plan | CentroidalPlan | - | optional; coming footholds, predicted centre of mass |
    | push | vector | 3 | N, in W; optional |

    Publishes every 1/32 s and has no output.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        plant: MultibodyPlant,
        meshcat: Meshcat,
        friction: float,
        ground: Ground | None = None,
    ) -> None:
        """Declare ports and the event.

        Args:
            humanoid: the robot.
            plant: the finalized plant that is simulated, with the ground.
            meshcat: where to draw.
            friction: of the friction cones [-].
            ground: where the ground is; without, z = 0.
        """
        super().__init__()
        self.set_name("overlays")
        self._humanoid = humanoid
        self._world = plant.world_body().index()
        self._scratch = humanoid.plant.CreateDefaultContext()
        self._painter = OverlayPainter(meshcat, 2.0 * humanoid.half_length, friction, ground)
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + humanoid.nv)
        self._contacts = self.DeclareAbstractInputPort(
            "contact_results", AbstractValue.Make(ContactResults())
        )
        anything = AbstractValue.Make(object())
        self._signals = [self.DeclareAbstractInputPort(name, anything) for name in SIGNALS]
        self._push = self.DeclareVectorInputPort("push", 3)
        self.DeclarePeriodicPublishEvent(PERIOD, 0.0, weak(self, self._publish))

    def _publish(self, context: Context) -> None:
        x = self._state.Eval(context)
        if np.isfinite(x).all():
            self._painter.draw(self._instant(context, x))

    def _instant(self, context: Context, x: Array) -> Instant:
        """Return what the input ports say."""
        instant = measured_instant(self._humanoid, self._scratch, context.get_time(), x)
        points = instant.contact_points
        if self._contacts.HasValue(context):
            results = self._contacts.Eval(context)
            instant.true_force = sum_at_ends(self._forces(results), points)
        if self._push.HasValue(context):
            instant.push = self._push.Eval(context)
        contact, targets, plan = (
            read_signal(self, port, context, kind) if port.HasValue(context) else None
            for port, kind in zip(self._signals, SIGNALS.values(), strict=True)
        )
        if contact is not None:
            instant.estimated_force = end_forces(contact.wrench, points)
        if targets is not None:
            instant.standing = np.array(targets.contact, dtype=float)
            if targets.swing is not None:
                instant.swing = targets.swing.p_WC
        if plan is not None:
            instant.planned = plan.footholds
            instant.predicted = com_ahead(plan)
        return instant

    def _forces(self, results: ContactResults) -> list[tuple[Array, Array]]:
        """Return point and force on the robot of each contact with the ground."""
        forces = []
        for k in range(results.num_point_pair_contacts()):
            info = results.point_pair_contact_info(k)
            sign = -1.0 if info.bodyB_index() == self._world else 1.0
            forces.append((info.contact_point(), sign * info.contact_force()))
        return forces
