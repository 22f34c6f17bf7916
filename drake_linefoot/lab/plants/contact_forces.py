"""The contact forces of each foot, added up from the point contacts of the plant."""

from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.systems.framework import BasicVector, Context

from drake_linefoot.axes import FEET, XYZ
from drake_linefoot.layout import Layout, Part, filler
from drake_linefoot.leaf_system import Block
from drake_linefoot.math.compiled import compiled
from drake_linefoot.parts import in_world
from drake_linefoot.robot.dynamics import dynamics_layout
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import open_dynamics
from drake_linefoot.types import Array


class FootContacts(NamedTuple):
    """The contact of the feet as the simulator has it."""

    points: Annotated[Array, in_world("ends of lines, corners of soles", "m", FEET, "nc", XYZ)]
    force: Annotated[Array, in_world("on each foot", "N", FEET, XYZ)]
    normal: Annotated[Array, Part("normal force on each point", "N", FEET, "nc")]
    slip: Annotated[Array, Part("speed of the fastest contact point", "m/s", FEET)]


fill_contacts = filler(FootContacts, "nc")


def contacts_layout(humanoid: Humanoid) -> Layout[FootContacts]:
    """Return how the contact of a robot's feet travels."""
    return Layout(FootContacts, humanoid.sizes)


def places_of_points(humanoid: Humanoid) -> Array:
    """Return where the contact points of a foot are from C, along x and y of C [m], shape (nc, 2).

    Those of `Humanoid.contact_points`, without the rounding of their middle.
    """
    signs = np.sign((humanoid.contact_points - humanoid.p_FC[:, None])[0, :, :2])
    return signs * [humanoid.half_length, humanoid.half_width]


class ContactForces(Block):
    """Adds up the contacts of each foot, for the recorder.

    .. pydrake_system::

        name: ContactForces
        input_ports:
        - contact_results
        - dynamics
        output_ports:
        - foot_contacts

    A contact between both feet counts for the foot that is its body B.
    """

    def __init__(self, humanoid: Humanoid, plant: MultibodyPlant) -> None:
        """Declare the ports; `plant` is the finalized one that is simulated."""
        super().__init__()
        self.set_name("contact_forces")
        names = humanoid.names_in(plant)
        self._feet = {  # 1 for the left one, 2 for the right one, by the index of the body
            int(names.frame(foot.frame).body().index()): 1 + side
            for side, foot in enumerate(humanoid.description.feet)
        }
        self._of_robot = humanoid.nv, humanoid.contact.size, places_of_points(humanoid)
        results = AbstractValue.Make(ContactResults())
        self._results = self.DeclareAbstractInputPort("contact_results", results)
        self._dynamics = self.signal_input("dynamics", dynamics_layout(humanoid))
        tickets = {self._results.ticket(), self._dynamics.ticket()}
        layout = contacts_layout(humanoid)
        self._size = layout.size
        self.signal_output("foot_contacts", layout, self._calc, tickets)

    def _calc(self, context: Context, output: BasicVector) -> None:
        contacts = contacts_of_feet(self._results.Eval(context), self._feet)
        flat, dynamics = np.empty(self._size), self._dynamics.Eval(context)
        foot_contacts(flat, dynamics, *self._of_robot, *contacts)
        output.SetFromVector(flat)


def contacts_of_feet(
    results: ContactResults, feet: Mapping[int, int]
) -> tuple[Array, Array, Array]:
    """Return the point contacts of the feet, n of them, as `foot_contacts` takes them.

    Args:
        results: of the plant.
        feet: 1 for the left foot, 2 for the right one, by the index of its body.
    """
    sides, vectors, slip = [], [], []
    for k in range(results.num_point_pair_contacts()):
        contact = results.point_pair_contact_info(k)
        on_A = feet.get(int(contact.bodyA_index()), 0)
        if side := feet.get(int(contact.bodyB_index()), -on_A):
            sides.append(float(side))
            vectors.append((contact.contact_force(), contact.contact_point()))
            slip.append(contact.slip_speed())
    at = np.array(vectors) if vectors else np.empty((0, 2, 3))
    return np.array(sides), at, np.array(slip)


@compiled
def foot_contacts(
    flat: Array,
    dynamics: Array,
    nv: int,
    nw: int,
    places: Array,
    feet: Array,
    at: Array,
    slip: Array,
) -> None:
    """Compute what the point contacts of a plant are to the feet.

    The nearest point of a foot bears the normal force of a contact.

    Args:
        flat: `FootContacts` is written here, as it travels.
        dynamics: of the robot, as it travels.
        nv: number of velocities.
        nw: how many numbers the wrench of a foot has.
        places: of the points, see `places_of_points`, shape (nc, 2).
        feet: of each contact, 1 for the left one, 2 for the right one; negative where the force
            is that on what it touches, shape (n,).
        at: force [N] and point [m] of each, in W, shape (n, 2, 3).
        slip: its speed [m/s], shape (n,).
    """
    nc = len(places)
    d, points = open_dynamics(dynamics, nv, nw), np.empty((2, nc, 3))
    force, normal, fastest = np.zeros((2, 3)), np.zeros((2, nc)), np.zeros(2)
    for side in range(2):
        for k in range(nc):
            points[side, k] = d.p_WC[side] + places[k, 0] * d.R_WC[side, :, 0]
            points[side, k] += places[k, 1] * d.R_WC[side, :, 1]
    for i in range(len(slip)):
        side, sign = int(abs(feet[i])) - 1, 1.0 if feet[i] > 0.0 else -1.0
        out = at[i, 1] - d.p_WC[side]
        ahead = (out * d.R_WC[side, :, 0]).sum() > 0.0
        left = (out * d.R_WC[side, :, 1]).sum() > 0.0
        k = nc // 2 if ahead else 0
        k += 1 if nc > 2 and not left else 0
        force[side] += sign * at[i, 0]
        normal[side, k] += sign * at[i, 0, 2]
        fastest[side] = max(fastest[side], slip[i])
    fill_contacts(flat, FootContacts(points, force, normal, fastest), nc)
