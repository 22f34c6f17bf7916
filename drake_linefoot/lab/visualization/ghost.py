"""The robot where the state estimator has it, and how sure that is."""

from typing import Any

import numpy as np
from pydrake.geometry import Rgba, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex

from drake_linefoot.lab.visualization.stage import Stage
from drake_linefoot.robot.humanoid import Humanoid

GHOST, DOUBT = "estimated robot", "estimated robot/3 sigma"
COLOUR, DOUBT_COLOUR = Rgba(0.15, 0.75, 0.80, 0.6), Rgba(0.15, 0.75, 0.80, 0.3)
RADIUS = 0.012  # [m] of a limb
LEAST = 1e-3  # [m] semi-axis that is drawn


class Ghost:
    """Limbs as rods from joint to joint at the estimated pose, and the ellipsoid of 3 sigma."""

    def __init__(self, humanoid: Humanoid, stage: Stage, metre: float) -> None:
        """Find the limbs; `metre` is what a metre of the MIT Humanoid is here [m]."""
        self._humanoid, self._stage, self._metre = humanoid, stage, metre
        plant, self._scratch = humanoid.plant, humanoid.plant.CreateDefaultContext()
        joints = (plant.get_joint(index) for index in plant.GetJointIndices())
        self._limbs = [
            (f"{GHOST}/{joint.name()}", joint.parent_body(), joint.child_body())
            for joint in joints
            if joint.parent_body().index() != BodyIndex(0)
        ]

    def start(self) -> None:
        """Make what will be moved about."""
        for name, *_ in self._limbs:
            self._stage.add_rod(name, RADIUS * self._metre, COLOUR)
        self._stage.add(DOUBT, Sphere(1.0), DOUBT_COLOUR)

    def draw(self, sample: Any) -> None:
        """Draw one instant, or nothing where there is no estimate; see `OverlayPainter.draw`."""
        pose = sample["estimate_pose"]
        known = bool(np.isfinite(pose).all())
        plant, context = self._humanoid.plant, self._scratch
        plant.SetPositions(
            context, np.concatenate([pose if known else sample["q"][:7], sample["q"][7:]])
        )
        for name, parent, child in self._limbs:
            begin, end = (plant.EvalBodyPoseInWorld(context, body) for body in (parent, child))
            self._stage.span(name, begin.translation(), end.translation(), known)
        self._stage.place(DOUBT, RigidTransform(pose[4:] if known else np.zeros(3)), known)
        if known:
            axes = np.maximum(3.0 * sample["estimate_sigma"][6:], LEAST)
            self._stage.stretch(DOUBT, axes)
