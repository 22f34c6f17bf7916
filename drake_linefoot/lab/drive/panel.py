"""The controls of a drive, as its pages show them: sliders, buttons, keys, stick, pointer."""

from typing import Any

import numpy as np

from drake_linefoot.lab.drive import teleop
from drake_linefoot.lab.drive.teleop import Seen, Tuning
from drake_linefoot.lab.visualization.controls import Button, Slider
from drake_linefoot.mpc.models.registry import MODELS
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import ratios, round_number, unit_value, units_of
from drake_linefoot.types import Array

# Ranges for the MIT Humanoid; by its unit each goes to another robot, and is rounded there.
# name, label, unit, step, least and largest value, keys for less and more, whether these steer
VELOCITIES = (
    ("forward", "forward m/s", "m/s", 0.1, -1.0, 2.6, "KeyS", "KeyW", False),  # fast ahead it runs
    ("left", "left m/s", "m/s", 0.05, -0.4, 0.4, "KeyD", "KeyA", True),
    ("turn", "turn rad/s", "rad/s", 0.1, -1.0, 1.0, "KeyE", "KeyQ", True),
)
# name, label, unit, step, least, largest
SINGLE_SUPPORT = ("step time", "step time s", "swing_time s", 0.01, 0.16, 0.32)
SWING_HEIGHT = ("step height", "step height m", "m", 0.01, 0.03, 0.12)
COM_HEIGHT = ("CoM height", "CoM height m", "m", 0.005)  # its range is the robot's
# and at first; goes by the impulse, for a push is as long for any robot
FORCE = ("push", "push N", "N s", 5.0, 0.0, 200.0, 25.0)
SPEEDS = (0.1, 1.0)  # [-] of real time
PUSHES, GAIT, TIME, MODELS_OF_MPC = "push", "gait", "time and recording", "model"  # what is folded
BUTTONS = {
    teleop.STOP: Button("stop", "KeyX"),
    teleop.PUSH: Button("push", "KeyP"),
    teleop.RESET: Button("reset", "KeyR"),
    teleop.PAUSE: Button("pause", "Space"),
    "push forward": Button("ahead", "ArrowUp", PUSHES),
    "push backward": Button("back", "ArrowDown", PUSHES),
    "push left": Button("left", "ArrowLeft", PUSHES),
    "push right": Button("right", "ArrowRight", PUSHES),
    teleop.RECORD: Button("record", "", TIME),
    teleop.STEP: Button("single step", "Period", TIME),
    teleop.ESTIMATE: Button("on the estimate", "KeyO", MODELS_OF_MPC),
}
LAST_BUTTONS = {teleop.QUIT: Button("quit", "Escape", TIME)}
MORE = (
    "Drag the robot with the mouse: a spring pulls its torso to the pointer. "
    "Gamepad: left stick walks, right stick turns."
)
REACH = 1.0  # [m] at which the spring of a pointer pulls with the largest push


class Panel:
    """Keeps what the pages set, within the ranges of the sliders.

    Attributes:
        sliders: by their names.
        buttons: by their actions; one for each model of the MPC.
        limits: least and largest velocities, shape (2, 3).
    """

    def __init__(self, tuning: Tuning, humanoid: Humanoid) -> None:
        """Begin with the tuning that is in force, and sliders in the size of the robot."""
        units = {"swing_time": float(ratios(humanoid)["swing_time"][0]), **units_of(humanoid)}
        models = {
            teleop.MODEL + name: Button(model.title, "", MODELS_OF_MPC)
            for name, model in MODELS.items()
        }
        self.buttons = {**BUTTONS, **models, **LAST_BUTTONS}
        self.sliders: dict[str, Slider] = {}
        self._stick: Array | None = None
        self._drag = np.zeros(3)
        for name, label, unit, step, *span, less, more, steers in VELOCITIES:
            by, least, largest = _rounded(unit_value(unit, units), step, *span)
            self.sliders[name] = Slider(label, least, largest, by, 0.0, less, more, steers)
        self.limits = np.array([[s.least, s.largest] for s in self.sliders.values()]).T
        heights = humanoid.description.limits
        for (name, label, unit, step, *ends), value in (
            (SINGLE_SUPPORT, tuning.single_support),
            (SWING_HEIGHT, tuning.swing_height),
            (COM_HEIGHT, tuning.com_height),
        ):
            by, *bounds = _rounded(unit_value(unit, units), step, *ends)
            least, largest = bounds or (heights.com_height_min, heights.com_height_max)
            # the scenario's own value is in the range
            least, largest = min(least, value), max(largest, value)
            self.sliders[name] = Slider(label, least, largest, by, value, fold=GAIT)
        name, label, unit, step, *forces = FORCE
        by, least, largest, first = _rounded(unit_value(unit, units), step, *forces)
        self.sliders[name] = Slider(label, least, largest, by, first, fold=PUSHES)
        self.sliders["speed"] = Slider("speed x real time", *SPEEDS, 0.1, 1.0, fold=TIME)
        self._reach = REACH * units["m"]

    def values(self) -> dict[str, float]:
        """Return the values of the sliders."""
        return {name: slider.value for name, slider in self.sliders.items()}

    def read(self, orders: list[dict[str, Any]]) -> Seen:
        """Return what was done.

        Args:
            orders: of pages since the last call, checked by `page_messages.order`; numbers are
                clipped to their ranges, names that there are not are passed over.
        """
        pressed = []
        for order in orders:
            for kind, value in order.items():
                if kind == "press" and value in self.buttons:
                    pressed.append(value)
                elif kind == "set" and value[0] in self.sliders:
                    self.sliders[value[0]].move(value[1])
                elif kind == "stick":
                    self._stick = None if value is None else np.array(value)
                elif kind == "drag":
                    self._drag = np.zeros(3) if value is None else np.array(value)
        value = self.values()
        return Seen(
            pressed=tuple(pressed),
            velocity=np.array([value[name] for name, *_ in VELOCITIES]),
            lengths=(value[SINGLE_SUPPORT[0]], value[SWING_HEIGHT[0]], value[COM_HEIGHT[0]]),
            force=value[FORCE[0]],
            stick=self._stick,
            speed=value["speed"],
            pull=self._pull(),
        )

    def move_sliders(self, velocity: Array) -> None:
        """Move the velocity sliders, shape (3,)."""
        for (name, *_), value in zip(VELOCITIES, velocity, strict=True):
            self.sliders[name].value = float(value)

    def _pull(self) -> Array | None:
        """Return the force of the pointer's spring in W [N], shape (3,); None without one."""
        length, most = float(np.linalg.norm(self._drag)), self.sliders[FORCE[0]].largest
        if length == 0.0:
            return None
        return most * min(1.0, length / self._reach) / length * self._drag


def _rounded(factor: float, step: float, *ends: float) -> list[float]:
    """Return step and ends of a slider times a factor, rounded: the ends to whole steps."""
    by = round_number(factor * step)
    return [by, *(by * round(factor * end / by) for end in ends)]
