"""The controls of a drive in Meshcat: buttons, sliders, gamepad, and lines of text."""

import math

import numpy as np
from pydrake.geometry import Meshcat

from drake_linefoot.drive.teleop import (
    CONTACT_CONSISTENT,
    ECD,
    PAUSE,
    PUSH,
    QUIT,
    RESET,
    SRBM,
    STOP,
    Seen,
    Tuning,
)
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.size import ratios, round_number, unit_value, units_of
from drake_linefoot.types import Array

# Ranges for the MIT Humanoid; by its unit each goes to another robot, and is rounded there.
# name in Meshcat, unit, largest value, step, keys for less and more; zero is in the middle
VELOCITIES = (
    ("ahead m/s (W S)", "m/s", 1.0, 0.1, "KeyS", "KeyW"),
    ("left m/s (A D)", "m/s", 0.4, 0.05, "KeyD", "KeyA"),
    ("turn rad/s (Q E)", "rad/s", 1.0, 0.1, "KeyE", "KeyQ"),
)
# name, unit, step, least, largest
SINGLE_SUPPORT = ("step time s", "swing_time s", 0.01, 0.16, 0.32)
SWING_HEIGHT = ("step height m", "m", 0.01, 0.03, 0.12)
COM_HEIGHT = ("CoM height m", "m", 0.005)  # its range is the robot's
# and at first; goes by the impulse, for a push is as long for any robot
FORCE = ("push N", "N s", 5.0, 0.0, 200.0, 25.0)
BUTTONS = {  # action: name in Meshcat, key
    STOP: ("Stop (X)", "KeyX"),
    PUSH: ("Push (P)", "KeyP"),
    "push forward": ("Push forward (Up)", "ArrowUp"),
    "push backward": ("Push backward (Down)", "ArrowDown"),
    "push left": ("Push left (Left)", "ArrowLeft"),
    "push right": ("Push right (Right)", "ArrowRight"),
    ECD: ("MPC: ECD", ""),
    CONTACT_CONSISTENT: ("MPC: contact-consistent", ""),
    SRBM: ("MPC: single rigid body", ""),
    PAUSE: ("Pause (Space)", "Space"),
    RESET: ("Reset (R)", "KeyR"),
    QUIT: ("Quit (Esc)", "Escape"),
}


class Panel:
    """Shows the controls and reads them. All calls from the thread that made `meshcat`.

    Attributes:
        limits: largest velocities of the sliders, shape (3,).
    """

    def __init__(self, meshcat: Meshcat, tuning: Tuning, humanoid: Humanoid) -> None:
        """Add the controls.

        Args:
            meshcat: where; its other controls are deleted.
            tuning: what the sliders begin with.
            humanoid: the robot, in whose size the sliders are.
        """
        self._meshcat = meshcat
        self._clicks = dict.fromkeys(BUTTONS, 0)
        self._lines: list[str] = []
        self._ranges: dict[str, tuple[float, float]] = {}
        self._values: dict[str, float] = {}  # of the sliders, the last good ones
        meshcat.DeleteAddedControls()
        for name, key in BUTTONS.values():
            meshcat.AddButton(name, key)
        units = {"swing_time": float(ratios(humanoid)["swing_time"][0]), **units_of(humanoid)}
        fastest = []
        for name, unit, most, step, less, more in VELOCITIES:
            by, largest = _rounded(unit_value(unit, units), step, most)
            meshcat.AddSlider(name, -largest, largest, by, 0.0, less, more)
            self._ranges[name], self._values[name] = (-largest, largest), 0.0
            fastest.append(largest)
        self.limits = np.array(fastest)
        self._lengths = []
        heights = humanoid.description.limits
        for (slider, unit, step, *ends), value in (
            (SINGLE_SUPPORT, tuning.single_support),
            (SWING_HEIGHT, tuning.swing_height),
            (COM_HEIGHT, tuning.com_height),
        ):
            by, *bounds = _rounded(unit_value(unit, units), step, *ends)
            least, largest = bounds or (heights.com_height_min, heights.com_height_max)
            # the scenario's own value is in the range, and a slider rounds
            low, high = min(least, value), max(largest, value)
            rounded = meshcat.AddSlider(slider, low, high, by, value)
            self._ranges[slider] = min(low, rounded), max(high, rounded)
            self._values[slider] = rounded
            self._lengths.append((slider, rounded, value))
        name, unit, step, *forces = FORCE
        by, least, largest, first = _rounded(unit_value(unit, units), step, *forces)
        meshcat.AddSlider(name, least, largest, by, first)
        self._ranges[name], self._values[name] = (least, largest), first

    def read(self) -> Seen:
        """Return what was done since the last call."""
        meshcat, pressed = self._meshcat, []
        for action, (name, _) in BUTTONS.items():
            clicks = meshcat.GetButtonClicks(name)
            pressed += [action] * (clicks - self._clicks[action])
            self._clicks[action] = clicks
        step_time, step_height, com_height = (
            given if (value := self._value(name)) == rounded else value
            for name, rounded, given in self._lengths
        )
        return Seen(
            pressed=tuple(pressed),
            velocity=np.array([self._value(name) for name, *_ in VELOCITIES]),
            lengths=(step_time, step_height, com_height),
            force=self._value(FORCE[0]),
            stick=self._stick(),
        )

    def move_sliders(self, velocity: Array) -> None:
        """Move the velocity sliders, shape (3,)."""
        for (name, *_), value in zip(VELOCITIES, velocity, strict=True):
            self._meshcat.SetSliderValue(name, float(value))

    def show(self, lines: list[str]) -> None:
        """Show lines of text under the controls; Meshcat has no text but names of buttons."""
        if lines == self._lines:
            return
        for line in self._lines:
            self._meshcat.DeleteButton(line)
        self._lines = list(dict.fromkeys(lines))  # names are unique
        for line in self._lines:
            self._meshcat.AddButton(line)

    def remove(self) -> None:
        """Take all controls away."""
        self._meshcat.DeleteAddedControls()

    def _value(self, name: str) -> float:
        """Return the value of a slider within its range: a page may send any number."""
        (low, high), value = self._ranges[name], self._meshcat.GetSliderValue(name)
        if math.isfinite(value):
            self._values[name] = min(max(value, low), high)
        return self._values[name]

    def _stick(self) -> Array | None:
        """Left stick: forward and left; right stick: turn. Pushed up is negative."""
        pad = self._meshcat.GetGamepad()
        if pad.index is None or len(pad.axes) < 2:
            return None
        turn = pad.axes[2] if len(pad.axes) > 2 else 0.0
        stick = -np.array([pad.axes[1], pad.axes[0], turn])
        return np.clip(np.nan_to_num(stick), -1.0, 1.0)


def _rounded(factor: float, step: float, *ends: float) -> list[float]:
    """Return step and ends of a slider times a factor, rounded: the ends to whole steps."""
    by = round_number(factor * step)
    return [by, *(by * round(factor * end / by) for end in ends)]
