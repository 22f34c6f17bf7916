"""The controller without a simulator: a state in, a torque out, tick by tick, as plain arrays."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, State

from drake_linefoot.errors import SignalError
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.math.linear import all_finite
from drake_linefoot.mpc.process_mpc import ProcessMpc
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import layouts
from drake_linefoot.terrain import TERRAIN, felt_ground
from drake_linefoot.types import Array
from drake_linefoot.wiring.controller import build_controller, connect_by_name
from drake_linefoot.wiring.parameters import ControllerParameters, ParametersOfBlocks
from drake_linefoot.wiring.warm_up import compile_first

STAND = (0.0, 0.0, 0.0, 0.0)  # v_x, v_y [m/s], turn rate [rad/s], walk (0 or 1)
_WALK = (0.3, 0.0, 0.1, 1.0)
_A_LITTLE = 900  # ticks in which all that a walk needs is called


class Controller:
    """Ticks a controller for a simulator, or a robot, of one's own.

        controller = Controller(humanoid)
        controller.warm_up()
        torque = controller.begin(state)
        while True:
            state, applied = step(torque)  # one period of yours
            torque = controller.tick(state, applied, [0.4, 0.0, 0.0, 1.0])

    A state is [q, v] as Drake has it, see `Humanoid`; a map is a `Terrain` as it travels, which
    `TERRAIN.vector` makes of one. The torques are those of the closed loop, to
    the bit.

    Attributes:
        humanoid: the robot.
        diagram: of `build_controller`.
        period: of the ticks [s].
    """

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: ParametersOfBlocks | None = None,
        diagram: Diagram | None = None,
        real_time: bool = False,
    ) -> None:
        """Build the controller, unless `diagram` is one; `begin` comes next.

        Args:
            humanoid: the robot.
            parameters: of the blocks, a `ControllerParameters` or a `Scenario`.
            diagram: used instead; it was built with the same parameters.
            real_time: a plan of `mpc.process` is waited for until its period is over on the clock
                on the wall, and then goes without; else as long as it takes.

        Raises:
            InputError: see `build_controller`.
        """
        parameters = parameters or ControllerParameters()
        self.humanoid, self.period = humanoid, parameters.period
        self.diagram = diagram or build_controller(humanoid, parameters)
        for system in self.diagram.GetSystems() if real_time else ():
            if isinstance(system, ProcessMpc):
                system.patience = parameters.mpc.period
        self._layouts = layouts(humanoid.sizes, parameters.mpc.knots)
        self._ticks = 0
        self._sizes = {"state": humanoid.nq + humanoid.nv, "applied_torque": humanoid.na}
        builder = DiagramBuilder()
        self._step = builder.AddSystem(_Step(self._sizes, self.period))
        builder.AddSystem(self.diagram)
        sources = {name: self._step.GetOutputPort(name) for name in self._sizes}
        connect_by_name(builder, self.diagram, sources)
        self._sizes |= {"command": len(STAND), "terrain": TERRAIN.size}
        builder.ExportInput(self._step.GetInputPort("measured"), "measured")
        for name in ("command", "terrain"):
            builder.ExportInput(self.diagram.GetInputPort(name), name)
        self._simulator = Simulator(builder.Build())
        self._context = self._simulator.get_mutable_context()
        self._fresh = self.save()

    def warm_up(self) -> None:
        """Compile all that a walk needs, with a bar on stderr where there is no machine code of it.

        Where there is, it has to be read: without this the first ticks of each kind of motion take
        up to a second, or a minute.
        """
        compile_first(self.walk_on_the_spot)
        self.walk_on_the_spot()

    def begin(self, state: ArrayLike, terrain: ArrayLike | None = None) -> Array:
        """Begin anew, at time 0, with both feet on the ground; return the first torque.

        Args:
            state: [q, v], shape (nq + nv,).
            terrain: a map of the ground, see `tick`.

        Returns:
            Torques [N m], shape (na,).

        Raises:
            SignalError: a number is not finite, or there are too few or too many.
        """
        x, ground = self._checked("state", state), self._ground(terrain)
        self.restore(self._fresh)
        measured = np.concatenate([x, np.zeros(self.humanoid.na)])
        self._step.GetMyMutableContextFromRoot(self._context).SetDiscreteState(measured)
        self._fix(measured, np.array(STAND), ground)
        self._simulator.Initialize()
        return self._torque()

    def tick(
        self,
        state: ArrayLike,
        applied_torque: ArrayLike,
        command: ArrayLike,
        terrain: ArrayLike | None = None,
    ) -> Array:
        """Go on by one period; return the torque for the next one.

        Args:
            state: [q, v] at the end of the period, shape (nq + nv,).
            applied_torque: of the motors in that period, which led to the state [N m], shape (na,).
            command: v_x, v_y [m/s] in the heading frame, turn rate [rad/s], walk (0 or 1), (4,).
            terrain: what is known of the ground now, shape (TERRAIN.size,); None: what feet feel.

        Returns:
            Torques [N m], shape (na,).

        Raises:
            SignalError: a number is not finite, or there are too few or too many; nothing has
                changed then, so that another tick may follow.
        """
        given = {"state": state, "applied_torque": applied_torque, "command": command}
        x, applied, told = (self._checked(name, value) for name, value in given.items())
        self._fix(np.concatenate([x, applied]), told, self._ground(terrain))
        self._ticks += 1
        self._simulator.AdvanceTo(self._ticks * self.period)
        return self._torque()

    def save(self) -> Array:
        """Return all that the controller knows, one array, for `restore`."""
        state = self._context.get_discrete_state()
        groups = [state.get_vector(i).value() for i in range(state.num_groups())]
        return np.concatenate([[float(self._ticks)], *groups])

    def restore(self, saved: ArrayLike) -> None:
        """Go on where a controller was that `save` has kept, this one or one built alike.

        Args:
            saved: what `save` returned.

        Raises:
            SignalError: it has another size.
        """
        numbers, state = np.array(saved, dtype=float), self._context.get_discrete_state()
        sizes = [1, *(state.get_vector(i).size() for i in range(state.num_groups()))]
        if numbers.shape != (sum(sizes),):
            text = f"has shape {numbers.shape}: must be ({sum(sizes)},)"
            raise SignalError("controller.saved", text)
        ticks, *groups = np.split(numbers, np.cumsum(sizes)[:-1])
        self._ticks = round(float(ticks[0]))
        self._context.SetTime(self._ticks * self.period)
        for i, group in enumerate(groups):
            self._context.SetDiscreteState(i, group)
        self._simulator.Initialize(InitializeParams(suppress_initialization_events=True))

    def look(self, name: str) -> Any:
        """Return what is on an output port, `contact`, `plan`, `report` ..., a signal opened."""
        own = self.diagram.GetMyContextFromRoot(self._context)
        value: Any = self.diagram.GetOutputPort(name).Eval(own)
        return self._layouts[name].open(value) if name in self._layouts else value

    def _torque(self) -> Array:
        own = self.diagram.GetMyContextFromRoot(self._context)
        torque: Array = self.diagram.GetOutputPort("torque").Eval(own)
        return torque

    def _checked(self, name: str, value: ArrayLike) -> Array:
        """Return what comes in as an array; SignalError for one that cannot be used."""
        array, size = np.array(value, dtype=float), self._sizes[name]
        if array.shape != (size,):
            raise SignalError(f"controller.{name}", f"has shape {array.shape}: must be ({size},)")
        if not all_finite(array):
            bad = int(np.flatnonzero(~np.isfinite(array))[0])
            text = f"element {bad} is {array[bad]}: must be finite"
            raise SignalError(f"controller.{name}", text)
        return array

    def _ground(self, terrain: ArrayLike | None) -> Array:
        """Return a map that comes in, or ground that is felt; SignalError as `_checked`."""
        return felt_ground() if terrain is None else self._checked("terrain", terrain)

    def _fix(self, measured: Array, command: Array, terrain: Array) -> None:
        whole: Any = self._simulator.get_system()
        inputs = {"measured": measured, "command": command, "terrain": terrain}
        for name, value in inputs.items():
            whole.GetInputPort(name).FixValue(self._context, value)

    def walk_on_the_spot(self) -> None:
        """Tick a robot that does not move, through steps of its gait; then forget it."""
        saved, x = self.save(), self.humanoid.x_nominal
        torque = self.begin(x)
        for _ in range(_A_LITTLE):
            torque = self.tick(x, torque, _WALK)
        self.restore(saved)


class _Step(Block):
    """Takes a plant's place: its unrestricted update puts out what was measured after a step.

    As with a plant, the other unrestricted updates of a tick (the MPC's) see what was before it,
    the discrete ones what is behind it.
    """

    def __init__(self, sizes: dict[str, int], period: float) -> None:
        """Declare ports, state and event; `sizes` of what is measured, by its name."""
        super().__init__()
        self.set_name("step")
        self._measured = self.DeclareVectorInputPort("measured", sum(sizes.values()))
        self.DeclareDiscreteState(sum(sizes.values()))
        first, after = sizes["state"], {self.xd_ticket()}
        self._parts = {"state": slice(first), "applied_torque": slice(first, None)}
        for name, calc in (("state", self._calc_state), ("applied_torque", self._calc_torque)):
            size = sizes[name]
            self.DeclareVectorOutputPort(name, size, weak(self, calc), prerequisites_of_calc=after)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, weak(self, self._update))

    def _update(self, context: Context, state: State) -> None:
        state.get_mutable_discrete_state(0).set_value(self._measured.Eval(context))

    def _calc_state(self, context: Context, output: BasicVector) -> None:
        self._give("state", context, output)

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        self._give("applied_torque", context, output)

    def _give(self, name: str, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_discrete_state_vector().value()[self._parts[name]])
