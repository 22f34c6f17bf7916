"""What the controller is told of the ground: patches of the scene near the robot, as they err."""

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.plants.map_file import read_map
from drake_linefoot.lab.plants.patch_ground import Outlines, outlines
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.courses import TerrainParameters
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.terrain import PATCHES, TERRAIN, Terrain, felt_ground
from drake_linefoot.types import Array

PERIOD = 0.02  # [s] between two maps
_FELT = felt_ground()
_NOISE = 3  # stream of random numbers


class TerrainMap(Block):
    """Tells the patches of ground near the robot.

    .. pydrake_system::

        name: TerrainMap
        input_ports:
        - state
        output_ports:
        - terrain

    Updates every 20 ms, from where the robot was `delay` ago; at times at which nothing is known
    it tells of one patch without an edge.
    """

    def __init__(self, humanoid: Humanoid, ground: Ground, scenario: Scenario) -> None:
        """Declare ports, state and events.

        Args:
            humanoid: the robot.
            ground: the true one.
            scenario: says what of it is known, how wrong that is, and the seed of the errors.
        """
        super().__init__()
        self.set_name("terrain_map")
        self._parameters = parameters = scenario.terrain
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + humanoid.nv)
        self._outlines = outlines(told(ground, scenario))
        self._late = max(round(parameters.delay / PERIOD), 0)
        # Where the robot was, and whether the ground is known.
        self._held = self.DeclareDiscreteState(2 * (self._late + 1) + 1)
        self.signal_output("terrain", TERRAIN, self._calc, {self.xd_ticket()})
        self.DeclareInitializationDiscreteUpdateEvent(weak(self, self._initialize))
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, weak(self, self._update))

    def _initialize(self, context: Context, discrete: DiscreteValues) -> None:
        here = np.tile(self._state.Eval(context)[4:6], self._late + 1)
        discrete.set_value([*here, self._is_known(context)])

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        here, before = self._state.Eval(context)[4:6], discrete.value()
        discrete.set_value([*before[2:-1], *here, self._is_known(context)])

    def _is_known(self, context: Context) -> bool:
        return self._parameters.is_known(context.get_time())

    def _calc(self, context: Context, output: BasicVector) -> None:
        held = context.get_discrete_state_vector().value()
        known = near(self._outlines, held[:2], self._parameters.range) if held[-1] else _FELT
        output.SetFromVector(known)


def told(ground: Ground, scenario: Scenario) -> Terrain:
    """Return all patches that may be told of a ground, as they err.

    Raises:
        InputError: the file of the map cannot be used.
    """
    known, random = scenario.terrain, np.random.default_rng([scenario.seed, _NOISE])
    true = ground.patches() if known.file is None else read_map(known.file)
    return erring(true, known, random)


def erring(true: Terrain, known: TerrainParameters, random: np.random.Generator) -> Terrain:
    """Return patches as they are known to a controller, moved and with the error that is stated."""
    count = len(true.sides)
    moved = known.noise * random.uniform(-1.0, 1.0, (count, 1, 3)) + known.offset
    plane, sigma = true.plane.copy(), true.sigma + known.error
    plane[:, 0] += moved[:, 0, 2] - np.sum(plane[:, 1:] * moved[:, 0, :2], axis=1)
    return true._replace(corners=true.corners + moved[..., :2], plane=plane, sigma=sigma)


def nearest(of: Outlines, here: Array, reach: float) -> NDArray[np.int64]:
    """Return which patches are nearest to a place, the nearest first; see `near`."""
    away = of.distances(here[None])[0]
    order = np.argsort(away, kind="stable")[:PATCHES]
    return order[(away[order] <= reach) | (np.arange(len(order)) == 0)]


def near(of: Outlines, here: Array, reach: float) -> Array:
    """Return the patches that are nearest to a place, as a `Terrain` travels.

    Args:
        of: any number of them.
        here: x, y [m].
        reach: those farther away are left out [m].
    """
    patches, order = of.patches, nearest(of, here, reach)
    width = patches.corners.shape[1]
    out = TERRAIN.open(vector := np.zeros(TERRAIN.size))
    n = len(order)
    vector[TERRAIN.place("number")] = n
    out.sides[:n], out.corners[:n, :width] = patches.sides[order], patches.corners[order]
    out.plane[:n], out.sigma[:n] = patches.plane[order], patches.sigma[order]
    return vector
