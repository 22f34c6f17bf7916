"""The controls of a drive in Meshcat: buttons, sliders, gamepad, and lines of text."""

import numpy as np
from pydrake.geometry import Meshcat

from drake_linefoot.drive.teleop import ECD, PAUSE, PUSH, QUIT, RESET, SRBM, STOP, Seen, Tuning
from drake_linefoot.types import Array

# name in Meshcat, largest value, step, keys for less and more; zero is in the middle
VELOCITIES = (
    ("ahead m/s (W S)", 1.0, 0.1, "KeyS", "KeyW"),
    ("left m/s (A D)", 0.4, 0.05, "KeyD", "KeyA"),
    ("turn rad/s (Q E)", 1.0, 0.1, "KeyE", "KeyQ"),
)
# name, least, largest, step
SINGLE_SUPPORT = ("step time s", 0.16, 0.32, 0.01)
SWING_HEIGHT = ("step height m", 0.03, 0.12, 0.01)
COM_HEIGHT = ("CoM height m", 0.005)  # its range is the robot's
FORCE = ("push N", 0.0, 200.0, 5.0)
FIRST_FORCE = 25.0  # [N]
BUTTONS = {  # action: name in Meshcat, key
    STOP: ("Stop (X)", "KeyX"),
    PUSH: ("Push (P)", "KeyP"),
    "push forward": ("Push forward (Up)", "ArrowUp"),
    "push backward": ("Push backward (Down)", "ArrowDown"),
    "push left": ("Push left (Left)", "ArrowLeft"),
    "push right": ("Push right (Right)", "ArrowRight"),
    ECD: ("MPC: ECD", ""),
    SRBM: ("MPC: single rigid body", ""),
    PAUSE: ("Pause (Space)", "Space"),
    RESET: ("Reset (R)", "KeyR"),
    QUIT: ("Quit (Esc)", "Escape"),
}


class Panel:
    """Shows the controls and reads them. All calls from the thread that made `meshcat`."""

    def __init__(self, meshcat: Meshcat, tuning: Tuning, com_heights: tuple[float, float]) -> None:
        """Add the controls.

        Args:
            meshcat: where; its other controls are deleted.
            tuning: what the sliders begin with.
            com_heights: least and largest height of the CoM [m].
        """
        self._meshcat = meshcat
        self._clicks = dict.fromkeys(BUTTONS, 0)
        self._lines: list[str] = []
        meshcat.DeleteAddedControls()
        for name, key in BUTTONS.values():
            meshcat.AddButton(name, key)
        for name, largest, step, less, more in VELOCITIES:
            meshcat.AddSlider(name, -largest, largest, step, 0.0, less, more)
        self._lengths = []
        name, step = COM_HEIGHT
        for (slider, least, largest, by), value in (
            (SINGLE_SUPPORT, tuning.single_support),
            (SWING_HEIGHT, tuning.swing_height),
            ((name, *com_heights, step), tuning.com_height),
        ):
            # the scenario's own value is in the range, and a slider rounds
            low, high = min(least, value), max(largest, value)
            rounded = meshcat.AddSlider(slider, low, high, by, value)
            self._lengths.append((slider, rounded, value))
        meshcat.AddSlider(*FORCE, FIRST_FORCE)

    @property
    def limits(self) -> Array:
        """Largest velocities of the sliders, shape (3,)."""
        return np.array([largest for _, largest, *_ in VELOCITIES])

    def read(self) -> Seen:
        """Return what was done since the last call."""
        meshcat, pressed = self._meshcat, []
        for action, (name, _) in BUTTONS.items():
            clicks = meshcat.GetButtonClicks(name)
            pressed += [action] * (clicks - self._clicks[action])
            self._clicks[action] = clicks
        step_time, step_height, com_height = (
            given if (value := meshcat.GetSliderValue(name)) == rounded else value
            for name, rounded, given in self._lengths
        )
        return Seen(
            pressed=tuple(pressed),
            velocity=np.array([meshcat.GetSliderValue(name) for name, *_ in VELOCITIES]),
            lengths=(step_time, step_height, com_height),
            force=meshcat.GetSliderValue(FORCE[0]),
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

    def _stick(self) -> Array | None:
        """Left stick: forward and left; right stick: turn. Pushed up is negative."""
        pad = self._meshcat.GetGamepad()
        if pad.index is None or len(pad.axes) < 2:
            return None
        turn = pad.axes[2] if len(pad.axes) > 2 else 0.0
        return -np.array([pad.axes[1], pad.axes[0], turn])
