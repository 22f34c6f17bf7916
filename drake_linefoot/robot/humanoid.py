"""A humanoid: its model in Drake plus what its description says.

The only place that knows joint and frame names; everything else uses the index arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from drake_linefoot.contact.contacts import Contact, LineContact
from drake_linefoot.contact.surface import SurfaceContact
from drake_linefoot.robot.description import (
    LINE,
    SURFACE,
    HumanoidDescription,
    load_description,
    robot_file,
)
from drake_linefoot.robot.floating_tree import FloatingTree
from drake_linefoot.robot.humanoid_view import HumanoidView
from drake_linefoot.robot.joint_limits import read_limits
from drake_linefoot.robot.mirror import derived_mirror, joint_lines, unlike_limits
from drake_linefoot.robot.model import add_model, base_name, foot_frame_name, parser_errors
from drake_linefoot.robot.model_file import read_model_file
from drake_linefoot.robot.names import Names
from drake_linefoot.robot.standing import check_standing, foot_clouds, nominal_configuration
from drake_linefoot.robot.tree import BASE_VELOCITIES, Tree
from drake_linefoot.robot.tree_model import read_tree
from drake_linefoot.types import Array

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

CONTACTS: dict[str, Callable[..., Contact]] = {LINE: LineContact, SURFACE: SurfaceContact}
_ACROSS = np.array([0.0, 1.0, 0.0])  # in a foot


class Humanoid(HumanoidView):
    """A biped with two feet that touch the ground along a line or with a sole.

    The state is Drake's x = [q, v] with q = [quaternion, p_WBo, joints] and
    v = [w_WB_W, v_WBo_W, joints]. Left before right, heel before toe.

    Attributes:
        description: what was read from the YAML file, with what that leaves to the model.
        notes: what was done to the model, a line each.
        base, torso: body B, x ahead and z up; the heaviest body that is welded to it, or itself.
        plant: the robot alone, continuous, without contact geometry, finalized.
        names: of its joints, bodies and frames there.
        nq, nv, na: numbers of positions, velocities and actuators; `sizes`: by these names, and
            nw, how many numbers the wrench of a foot has, and nc, how many `contact_points`.
        world: frame W.
        floating: what floats: its mass and centre of mass.
        mass: total mass [kg].
        half_length, half_width: X and Y, half of what the feet touch with [m]; Y is 0 for a line.
        contact: of each foot, smaller by the margin of the description.
        contact_points: that touch flat ground, in the foot frame [m], shape (2, n, 3): heel and
            toe of a line, of a surface heel left, heel right, toe left, toe right.
        sole_width: across the line, of the collision shapes of a foot in the model [m]; 0 where
            there are none, or nothing was checked.
        p_FC: middle of each foot's contact in the foot frame [m], shape (2, 3).
        leg_joints, arm_joints: which actuators the joints of both legs are, shape (2, n_leg), and
            those of the arms.
        leg_v, leg_q: index arrays of the leg joints in v and q, shape (2, n_leg).
        arm_v, arm_q: index arrays of the arm joints in v and q.
        actuated_v: index in v of each actuator, shape (na,).
        effort_limits: symmetric torque limits [N m], shape (na,).
        position_lower, position_upper: joint limits [rad], shape (na,), actuator order.
        velocity_limits: symmetric joint speed limits [rad/s], shape (na,).
        q_nominal: nominal posture standing on z = 0, shape (nq,).
        com_height: of the CoM above the ground in that posture [m].
        scratch: a context of the plant, overwritten by whoever computes something at once; with
            one for all blocks its memory stays near the processor.
    """

    def __init__(
        self,
        description: HumanoidDescription,
        checked: bool = True,
        contact: Callable[..., Contact] | None = None,
    ) -> None:
        """Parse the model and resolve every name of the description.

        Args:
            description: what was read; what it leaves to the model is filled in.
            checked: whether the robot must be able to stand as described.
            contact: makes the contact of its feet, of half their length [m] and, where the
                description says surface, half their width [m]; None: that of the description.

        Raises:
            ModelError: the model does not parse, or a name or a number does not fit it.
        """
        self.description = description
        self._model = read_model_file(description.model, description.file)
        self.plant = MultibodyPlant(0.0)
        self._added: WeakKeyDictionary[MultibodyPlant, Names] = WeakKeyDictionary()
        self.notes = tuple(self.add_to(self.plant))
        self.names = self.names_in(self.plant)
        with parser_errors(description.file, "model", str(description.model)):
            self.plant.Finalize()
        self.nq, self.nv = int(self.plant.num_positions()), int(self.plant.num_velocities())
        self.na = int(self.plant.num_actuators())
        self.sizes = {"nq": self.nq, "nv": self.nv, "na": self.na}
        self.world = self.plant.world_frame()
        self._resolve_base()
        self._resolve_joints()
        self._resolve_feet()
        self.contact = self._contact_of(contact or CONTACTS[description.contact])
        self.sizes |= {"nw": self.contact.size, "nc": self.contact_points.shape[1]}
        self._read_limits()
        self.scratch = self.plant.CreateDefaultContext()
        self._trees: WeakKeyDictionary[Context, Tree | None] = WeakKeyDictionary()
        self._resolve_mirror()
        self.floating = FloatingTree(self.plant)
        self.mass: float = self.floating.mass
        self.q_nominal = nominal_configuration(self)
        self.plant.SetPositions(self.scratch, self.q_nominal)
        self.com_height = float(self.floating.com(self.scratch)[2])
        self.sole_width = 0.0
        if checked:
            clouds = foot_clouds(self, self._model)
            soles = [cloud.sole() for cloud in clouds if cloud is not None]
            widths = [sole.reach(_ACROSS) + sole.reach(-_ACROSS) for sole in soles]
            self.sole_width = max(widths, default=0.0)
            self.notes += tuple(check_standing(self, clouds))

    @property
    def x_nominal(self) -> Array:
        """The nominal posture at rest, shape (nq + nv,)."""
        return np.concatenate([self.q_nominal, np.zeros(self.nv)])

    def tree(self, context: Context) -> Tree | None:
        """Return the tree of links with the masses of a context, as read when first asked for.

        None when the model is not one, see `read_tree`.
        """
        if context not in self._trees:
            args = self.plant, context, self.base, self.foot_frames, self.p_FC
            self._trees[context] = read_tree(*args)
        return self._trees[context]

    def add_to(
        self, plant: MultibodyPlant, drawn: bool = True, name: str | None = None
    ) -> list[str]:
        """Add the robot to `plant`, before it is finalized; return what was done to it.

        Drawings, whose meshes take a while where Meshcat does not show their kind, may be left out.
        The model instance has the name that is given, or the model's, with a number where another
        has that; `names_in` says which one it is. Each robot in a plant is a Humanoid of its own.

        Raises:
            ModelError: the model cannot be parsed, or the name is taken.
        """
        names, notes = add_model(plant, self.description, self._model, drawn, name)
        self._added[plant] = names
        return notes

    def names_in(self, plant: MultibodyPlant) -> Names:
        """Return where the robot's parts are in a plant; `root` is its model instance there."""
        if plant not in self._added:  # a copy, as of a saved diagram
            same = map(self.plant.GetModelInstanceName, self.names.instances)
            found = [plant.GetModelInstanceByName(name) for name in same]
            self._added[plant] = Names(plant, found, self.description.floating_base)
        return self._added[plant]

    def _resolve_base(self) -> None:
        d = self.description
        self.base = self.names.body(base_name(d))
        welded = self.plant.GetBodiesWeldedTo(self.base)
        self.torso = max(welded, key=lambda body: body.default_mass())
        if not self.base.is_floating_base_body() or not self.base.has_quaternion_dofs():
            raise d.refuse("floating_base", d.floating_base, "is not a floating body of the model")
        if self.base.floating_positions_start() != 0 or self.base.floating_velocities_start_in_v():
            raise d.refuse("floating_base", d.floating_base, "must be the first body of the model")

    def _joint_index(self, entry: str, name: str) -> tuple[int, int]:
        """Return where a one-degree-of-freedom joint stands in q and in v."""
        if not self.names.has_joint(name):
            raise self.description.refuse(entry, name, "no such joint in the model")
        joint = self.names.joint(name)
        if joint.num_velocities() != 1:
            raise self.description.refuse(entry, name, "must be a joint with one degree of freedom")
        return joint.position_start(), joint.velocity_start()

    def _motors(self) -> list[str]:
        """Return the joints that have an actuator, in the order of torques."""
        motors = [self.plant.get_joint_actuator(i) for i in self.plant.GetJointActuatorIndices()]
        return [
            self.names.name_of(motor.joint())
            for motor in sorted(motors, key=lambda m: m.input_start())
        ]

    def _resolve_joints(self) -> None:
        """Find the joints; those that the description leaves to the model are filled in."""
        d, plant, motors = self.description, self.plant, self._motors()
        names = d.actuated_joints or tuple(motors)
        left, right = (foot.leg_joints for foot in d.feet)
        arms = d.arm_joints or tuple(name for name in names if name not in {*left, *right})
        self.description = d = replace(d, actuated_joints=names, arm_joints=arms)
        if plant.num_actuators() != len(names):
            found = f"the model has {plant.num_actuators()} actuators"
            raise d.refuse("actuated_joints", f"{len(names)} names", found)
        at = [self._joint_index(f"actuated_joints[{i}]", name) for i, name in enumerate(names)]
        for i, (name, joint) in enumerate(zip(names, motors, strict=True)):
            if name != joint:
                raise d.refuse(f"actuated_joints[{i}]", name, f"the model has {joint!r} here")
        if plant.num_velocities() != BASE_VELOCITIES + len(names):
            moving = [j for j in self.names.joints() if j.num_velocities() == 1]
            more = [n for n in map(self.names.name_of, moving) if n not in names]
            for name in more:
                if name in {*left, *right}:
                    allowed = "joint of a leg has no effort limit above 0, or no actuator"
                    raise d.refuse("model", name, allowed)
            allowed = f"the model has more joints, which must be locked: {more[:6]}"
            raise d.refuse("actuated_joints", f"{len(names)} names", allowed)
        groups = {"feet[0].leg_joints": left, "feet[1].leg_joints": right, "arm_joints": arms}
        for entry, group in groups.items():
            for name in group:
                if name not in names:
                    raise d.refuse(entry, name, "is not an actuated joint")
        if sorted([*left, *right, *arms]) != sorted(names):
            raise d.refuse("arm_joints", list(arms), "legs and arms must be all joints")
        if len(left) != len(right):
            raise d.refuse("feet[1].leg_joints", list(right), "both legs need as many joints")
        self.actuated_q = np.array([in_q for in_q, _ in at])
        self.actuated_v = np.array([in_v for _, in_v in at])
        self.leg_joints = np.array([[names.index(name) for name in leg] for leg in (left, right)])
        self.leg_q, self.leg_v = self.actuated_q[self.leg_joints], self.actuated_v[self.leg_joints]
        self.arm_joints = np.array([names.index(name) for name in arms], dtype=int)
        self.arm_q, self.arm_v = self.actuated_q[self.arm_joints], self.actuated_v[self.arm_joints]

    def _resolve_feet(self) -> None:
        feet = self.description.feet
        self.foot_frames = [self.names.frame(foot_frame_name(foot)) for foot in feet]
        points = np.array([foot.contact_points for foot in feet])
        self.half_length, self.half_width = feet[0].halves  # both feet have the same
        self.p_FC = points.mean(axis=1)
        self.contact_points = np.array([foot.ground_points for foot in feet])

    def _contact_of(self, kind: Callable[..., Contact]) -> Contact:
        margin = self.description.contact_margin
        halves = (self.half_length, self.half_width)[: 2 if self.half_width else 1]
        return kind(*(half - margin for half in halves))

    def _read_limits(self) -> None:
        index = self.actuated_q, self.actuated_v
        limits = read_limits(self.plant, self.description, *index)
        self.position_lower, self.position_upper, self.velocity_limits, self.effort_limits = limits

    def _resolve_mirror(self) -> None:
        d = self.description
        mirror = d.mirror or derived_mirror(d, self.names, self.base.body_frame())
        self.description = replace(d, mirror=mirror)
        index = {name: i for i, name in enumerate(d.actuated_joints)}
        legs = [name for foot in d.feet for name in foot.leg_joints]
        _, axes = joint_lines(self.names, self.base.body_frame(), d.actuated_joints)
        self.notes += unlike_limits(
            self.description, axes, self.position_lower, self.position_upper, legs
        )
        self._mirror_index = np.empty(self.na, dtype=int)
        self._mirror_sign = np.empty(self.na)
        for left, (right, sign) in mirror.items():
            i, j = index[left], index[right]
            self._mirror_index[[i, j]] = j, i
            self._mirror_sign[[i, j]] = sign

    def mirror_joints(self, values: Array) -> Array:
        """Mirror joint angles, rates or torques in actuator order, shape (na,)."""
        return self._mirror_sign * values[self._mirror_index]

    def mirror_state(self, x: Array) -> Array:
        """Mirror a state in the plane y = 0, shape (nq + nv,)."""
        y = np.array(x, dtype=float)
        q, v = y[: self.nq], y[self.nq :]
        q[[1, 3, 5]] *= -1.0  # quaternion x and z, position y
        v[[0, 2, 4]] *= -1.0  # roll and yaw rate, velocity y
        q[self.actuated_q] = self.mirror_joints(q[self.actuated_q])
        v[self.actuated_v] = self.mirror_joints(v[self.actuated_v])
        return y


def load_humanoid(name: str | Path, contact: Callable[..., Contact] | None = None) -> Humanoid:
    """Load a shipped robot ("mit_humanoid"), or one by its folder or description.

    Args:
        name: of the robot, or the path, see `robot_file`.
        contact: makes the contact of its feet instead of the description's, see `Humanoid`.

    Raises:
        ModelError: no such robot, or its description or model is not usable.
    """
    return Humanoid(load_description(robot_file(name)), contact=contact)
