"""A contact of your own: a line whose ends have friction pyramids with eight sides.

It says which wrenches the ground gives, as rows ``W w <= 0``; all of the controller goes by them.

    python examples/10_own_contact.py
"""

import argparse
from itertools import product

import numpy as np

from drake_linefoot import (
    Scenario,
    Segment,
    build_closed_loop,
    build_controller,
    load_humanoid,
    simulate,
)
from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.contact.wrench_cone import BOTH, HEEL, TOE


class OctagonalLine(LineContact):
    """Each end keeps to |f_x|, |f_y| <= mu f_z and |f_x| + |f_y| <= sqrt(2) mu f_z."""

    ends = np.array([HEEL, HEEL, TOE, TOE] + [BOTH] * 18)

    def cone(self, mu):
        # Only the sum of both f_x counts: it must keep to what both ends leave for it.
        along, rows, left = np.array([1.0, 0.0, 0.0, 0.0, 0.0]), [], []
        for end in (-self.half_length, self.half_length):  # x of heel and toe
            f_y = np.array([0.0, 0.5, 0.0, 0.0, 0.5 / end])
            friction = mu * np.array([0.0, 0.0, 0.5, -0.5 / end, 0.0])  # mu f_z
            rows += [f_y - friction, -f_y - friction]
            left.append([friction, 2**0.5 * friction - f_y, 2**0.5 * friction + f_y])
        for heel, toe in product(*left):
            rows += [along - heel - toe, -along - heel - toe]
        return np.array(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=4.0, help="of walking")
    seconds = parser.parse_args().seconds
    ahead = Segment("ahead", seconds, walk=True, velocity=[0.5, 0.0], turn_rate=0.3)
    scenario = Scenario(segments=[Segment("stand", 0.5), ahead])
    for contact in (LineContact, OctagonalLine):
        humanoid = load_humanoid(scenario.robot, contact=contact)
        controller = build_controller(humanoid, scenario)
        run = simulate(build_closed_loop(scenario, controller=controller))
        f = run.wbc_wrench[run.wbc_wrench[..., 2] > 20.0]  # [N] of feet that bear
        share = (np.abs(f[:, :2]).sum(axis=1) / f[:, 2]).max()
        rows = len(humanoid.contact.ends)
        print(f"{rows} rows; fell: {run.fell}; |f_x| + |f_y| at most {share:.2f} f_z")


if __name__ == "__main__":
    main()
