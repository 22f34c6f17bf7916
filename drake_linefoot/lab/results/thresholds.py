"""From where on something in the record of a run counts, in the size of its robot."""

from dataclasses import dataclass
from typing import Annotated

from drake_linefoot.fields import Positive, ScaledDefault, Unit
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.robot.scaling import scaled

Seconds = Annotated[Positive, Unit("s")]
Metres = Annotated[Positive, Unit("m")]


@dataclass
class Thresholds:
    """What a run is judged by; each time is one of a walk, none of how it is sampled."""

    load: Annotated[Positive, Unit("N")] = ScaledDefault(5.0)
    """Normal force above which a foot or a contact point is loaded."""
    shortest_swing: Seconds = ScaledDefault(0.05)
    """A foot that is unloaded for less than this has bounced, not swung."""
    shortest_stance: Seconds = ScaledDefault(0.005)
    """A swinging foot that is loaded for less than this has scuffed."""
    shortest_flight: Seconds = ScaledDefault(0.01)
    """With no foot loaded for less than this a walk has changed its feet."""
    recent: Seconds = ScaledDefault(0.01)
    """After true load, in which a flag is no false one."""
    detection_time: Seconds = ScaledDefault(0.05)
    """After which a touchdown, or a lift-off, counts as missed."""
    settled: Seconds = ScaledDefault(1.0)
    """At the end of a run, over which the joint speed is taken."""
    smoothing: Seconds = ScaledDefault(0.4)
    """Window of the measured velocity in plots, about one stride."""
    stands: Seconds = ScaledDefault(0.02)
    """For which a foot is loaded before it can slip."""
    slipped: Metres = ScaledDefault(0.03)
    """Way of a contact point that has slid."""
    stopped: Seconds = ScaledDefault(0.01)
    """For which a joint is at its stop."""
    moved: Seconds = ScaledDefault(0.02)
    """Of a swing, for which a limit moves its foothold."""
    lateness: Seconds = ScaledDefault(0.015)
    """Of a touchdown, after it was due."""
    miss: Metres = ScaledDefault(0.04)
    """Of a touchdown, beside its target."""
    astray: Annotated[Positive, Unit("m/s")] = ScaledDefault(0.1)
    """Of a velocity that is not the one commanded, where that is smaller."""
    turned: Annotated[Positive, Unit("rad/s")] = ScaledDefault(0.15)
    """Of a turn rate, likewise."""
    falling: Seconds = ScaledDefault(0.03)
    """After the onset of a fall; later all that is seen is the fall itself."""


def thresholds_of(run: Run) -> Thresholds:
    """Return what a run is judged by, in the size of its robot."""
    return scaled(Thresholds(), robot_of(run))
