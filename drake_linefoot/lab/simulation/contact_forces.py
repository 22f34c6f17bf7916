"""The contact forces of each foot, added up from the point contacts of the plant."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import ContactResults


def write_contacts(
    results: Sequence[ContactResults], rows: NDArray[np.void], feet: Mapping[int, int]
) -> None:
    """Write the force on each foot, the normal forces of heel and toe, and the slip speed.

    The nearer one of heel and toe bears the normal force of a contact. A contact between both
    feet counts for the foot that is its body B.

    Args:
        results: of the plant in each of n ticks.
        rows: of the channels; their contact points are there, shape (n,).
        feet: side of each foot, by the index of its body.
    """
    n = len(results)
    tick = np.repeat(np.arange(n), [one.num_point_pair_contacts() for one in results])
    infos = [
        one.point_pair_contact_info(k)
        for one in results
        for k in range(one.num_point_pair_contacts())
    ]
    on_A = np.array([feet.get(int(info.bodyA_index()), -1) for info in infos], dtype=int)
    on_B = np.array([feet.get(int(info.bodyB_index()), -1) for info in infos], dtype=int)
    force = np.array([info.contact_force() for info in infos]).reshape(-1, 3)  # on body B
    point = np.array([info.contact_point() for info in infos]).reshape(-1, 3)
    speed = np.array([info.slip_speed() for info in infos])
    side, sign = np.where(on_B < 0, on_A, on_B), np.where(on_B < 0, -1.0, 1.0)
    count = side >= 0
    foot, force = (2 * tick + side)[count], (sign[:, None] * force)[count]  # of all ticks
    heel, toe = rows["contact_points"].reshape(-1, 2, 3)[foot].swapaxes(0, 1)
    ahead = ((toe - heel) * (point[count] - 0.5 * (heel + toe))).sum(axis=1)  # of the middle
    for axis in range(3):
        total = np.bincount(foot, force[:, axis], 2 * n)
        rows["true_force"][:, :, axis] = total.reshape(n, 2)
    normal = np.bincount(2 * foot + (ahead > 0.0), force[:, 2], 4 * n)
    rows["true_normal"] = normal.reshape(n, 2, 2)
    slip = np.zeros(2 * n)
    np.maximum.at(slip, foot, speed[count])
    rows["slip_speed"] = slip.reshape(n, 2)
