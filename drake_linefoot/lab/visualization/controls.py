"""The controls of a live page: sliders and buttons, by their names."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.visualization.overlays import legend_of
from drake_linefoot.lab.visualization.replay import torso_path
from drake_linefoot.robot.humanoid import Humanoid


@dataclass
class Slider:
    """A number that a page sets."""

    label: str  # what it is, with its unit
    least: float
    largest: float
    step: float  # what a key adds
    value: float  # now
    less: str = ""  # keys, by their names in a browser; empty for none
    more: str = ""
    steers: bool = False  # whether it goes back to where it was when its key is let go
    fold: str = ""  # heading under which it is folded; empty: always seen

    def move(self, value: float) -> None:
        """Set the value, clipped to the range."""
        self.value = min(max(value, self.least), self.largest)


@dataclass
class Button:
    """Something that a page presses."""

    label: str
    key: str = ""  # by its name in a browser; empty for none
    fold: str = ""  # as of a `Slider`


def page_setup(
    title: str,
    humanoid: Humanoid,
    sliders: Mapping[str, Slider] | None = None,
    buttons: Mapping[str, Button] | None = None,
    *,
    scenario: Scenario | None = None,
    more: str = "",
) -> dict[str, Any]:
    """Return what a live page shows, for `Link.show("setup", ...)`.

    Args:
        title: of the page.
        humanoid: the robot that the camera follows.
        sliders: by their names.
        buttons: by what they do.
        scenario: of the loop of which there are numbers, plots and overlays.
        more: to know, behind a question mark.
    """
    return {
        "title": title,
        "torso": torso_path(humanoid),
        "sliders": [{"name": name, **asdict(each)} for name, each in (sliders or {}).items()],
        "buttons": [{"name": name, **asdict(each)} for name, each in (buttons or {}).items()],
        "legend": [] if scenario is None else legend_of(scenario),
        "help": more,
    }
