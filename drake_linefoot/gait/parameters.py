"""Parameters of the gait."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Le, Len
from pydantic import Strict

from drake_linefoot.fields import (
    Flag,
    Fraction,
    NotNegative,
    Number,
    Positive,
    ScaledDefault,
    Share,
    Size,
    TickOrMore,
    Unit,
    Whole,
    misfit,
    one_of,
    together,
)
from drake_linefoot.parameters import Parameters


@dataclass
class GaitParameters(Parameters):
    """How the robot steps; `ScaledDefault` defaults are those of the MIT Humanoid."""

    single_support: Annotated[TickOrMore, Size("swing_time")] = ScaledDefault(0.20)
    double_support: TickOrMore = ScaledDefault(0.03)
    double_support_min: TickOrMore = ScaledDefault(0.012)
    """Of recovery steps, and not longer than `double_support`."""
    recovery_steps: Annotated[Whole, Ge(0), Le(100)] = 3
    """After an insufficient step; 0: none."""
    short_step: Annotated[Positive, Unit("m")] = ScaledDefault(0.04)
    """A foothold so far from where the offset of the DCM would be nominal is insufficient."""
    step_length: Annotated[Positive, Unit("m"), Size("swing_time")] = ScaledDefault(0.28)
    """Forward; a walk whose steps would be longer steps faster."""
    single_support_min: Annotated[TickOrMore, Size("swing_time")] = ScaledDefault(0.14)
    """But not faster than this."""
    shift_duration: TickOrMore = ScaledDefault(0.40)
    """Weight shift before the first step."""
    shift_duration_min: Annotated[Positive, Unit("s")] = ScaledDefault(0.08)
    """When less of it is left, the balancing CoP is not updated any more."""
    step_width: Annotated[NotNegative, Unit("m")] = ScaledDefault(0.16)
    """Between the feet."""
    swing_height: Annotated[Positive, Unit("m")] = ScaledDefault(0.06)
    """Apex of the swing foot."""
    swing_height_uneven: Annotated[Positive, Unit("m")] = ScaledDefault(0.12)
    """Where it is uneven, 1.6 times `unevenness_max`; not lower than `swing_height`."""
    com_height: Annotated[NotNegative, Unit("m")] = ScaledDefault(0.642)
    """Above the stance foot."""
    linear_acceleration: Annotated[Positive, Unit("m/s^2")] = 1.0
    """Rate limit of the commanded velocity."""
    angular_acceleration: Annotated[Positive, Unit("rad/s^2")] = ScaledDefault(1.5)
    """Rate limit of the commanded turn rate."""
    forward_max: Annotated[NotNegative, Unit("m/s")] = ScaledDefault(2.6)
    """Commands are clipped here, forward and backward; sooner where legs swing too slowly."""
    walk_max: Annotated[NotNegative, Unit("m/s")] = ScaledDefault(1.5)
    """And here where it does not run: `flight` is 0, its legs are too slow, the ground uneven."""
    lateral_max: Annotated[NotNegative, Unit("m/s")] = ScaledDefault(0.5)
    turn_max: Annotated[NotNegative, Unit("rad/s")] = ScaledDefault(2.0)
    lean_max: Annotated[NotNegative, Unit("m")] = ScaledDefault(0.12)
    """So far the CoM is moved against a force that lasts."""
    capture_rate: Annotated[Positive, Unit("1/s")] = ScaledDefault(3.0)
    """How fast a standing robot brings its DCM to the middle."""
    speed_scale: Annotated[list[Positive], Strict(), Len(2, 2), Unit("-")] = field(
        default_factory=lambda: [1.12, 1.2]
    )
    """Of the commanded velocity, forward and left, that footholds are made for; where learning
    starts."""
    speed_learning: Fraction = 0.18
    """Share of the relative speed error learned each step."""
    speed_offset_learning: Fraction = 0.15
    """Share of a speed error at rest learned each step."""
    speed_learning_slow: Annotated[Positive, Unit("m/s")] = ScaledDefault(0.1)
    """Commands below it teach an offset of the speed, above it a scale."""
    speed_scale_max: Annotated[Number, Ge(1), Unit("-")] = 1.5
    """Bound of the learned scale; 1 / it is the other bound."""
    speed_offset_max: Annotated[NotNegative, Unit("m/s")] = ScaledDefault(0.2)
    """Bound of the learned offset."""
    contact_feedback: Flag = True
    """A swing ends when the estimator says so; else when planned."""
    early_contact_phase: Fraction = 0.6
    """Of the swing; contact before it is not believed."""
    contact_speed: Annotated[Positive, Unit("m/s")] = ScaledDefault(0.1)
    """A foot that goes down faster has found no ground yet."""
    late_contact_max: Annotated[NotNegative, Unit("s")] = ScaledDefault(0.03)
    """A foot that finds no ground reaches down for so long."""
    late_contact_wait: Annotated[NotNegative, Unit("s")] = ScaledDefault(0.01)
    """After which one that does not follow has found it."""
    late_contact_height: Annotated[Positive, Unit("m")] = ScaledDefault(0.02)
    """A late foot farther above where it should be has not come to the ground."""
    reach_speed: Annotated[Positive, Unit("m/s")] = ScaledDefault(0.2)
    """At which it does."""
    slope_learning: Annotated[NotNegative, Unit("-")] = 1.0
    """Weight of what two feet say of the slope against the belief."""
    slope_baseline: Annotated[Positive, Unit("m")] = ScaledDefault(0.05)
    """Feet that are nearer to each other tell no slope between them."""
    slope_feel_time: Annotated[NotNegative, Unit("s")] = ScaledDefault(0.02)
    """After so long on one foot the rise along its line is taken for that of the ground."""
    unevenness_max: Annotated[Positive, Unit("m")] = ScaledDefault(0.007)
    """But not where the last steps met the ground farther from where it was expected."""
    slope_max: Fraction = 0.3
    """Bound of the slope, in x and in y."""
    climb_max: Annotated[Positive, Unit("m/s")] = ScaledDefault(0.13)
    """Where the ground has a slope, the speed times the slope is at most this."""
    stairs_climb_max: Annotated[Positive, Unit("m/s")] = ScaledDefault(0.25)
    """Likewise of steps of known ground, up or down."""
    careful_speed: Annotated[NotNegative, Unit("m/s")] = ScaledDefault(0.3)
    """At most, where the ground is as uneven as `unevenness_max` or has `friction_careful`."""
    friction_careful: Share = 0.4
    """Of ground that is walked at `careful_speed`."""
    friction_firm: Share = 0.6
    """Of ground that is walked at any speed; above `friction_careful`."""
    slip_min: Annotated[Positive, Unit("m")] = ScaledDefault(0.005)
    """A stance foot that has slid by less tells nothing of the friction."""
    reach_forward: Annotated[Positive, Unit("m")] = ScaledDefault(0.22)
    """Of a landing foot from the CoM, ahead or behind."""
    reach_outward: Annotated[Positive, Unit("m")] = ScaledDefault(0.28)
    """Of a landing foot from the CoM, to its own side."""
    crossing_max: Annotated[NotNegative, Unit("m")] = ScaledDefault(0.1)
    """Of a landing foot beyond the stance foot, where no other step saves the robot; 0: never."""
    crossing_gap: Annotated[Positive, Unit("m")] = ScaledDefault(0.05)
    """Between the middles of the feet on the way there; a fifth of it between wider soles."""
    settle_time: Annotated[NotNegative, Unit("s")] = ScaledDefault(0.03)
    """Before touchdown the foot is above its foothold."""
    freeze_time: Annotated[NotNegative, Unit("s")] = ScaledDefault(0.02)
    """Before that the foothold moves no more."""
    edge_margin: Annotated[NotNegative, Unit("m")] = ScaledDefault(0.015)
    """Of a foot from the edge of a patch of known ground, beside what that may be off."""
    shank_lean: Annotated[NotNegative, Le(1.2), Unit("rad")] = 0.75
    """Of a shank ahead, at most, by which a foot keeps away from a riser that it would meet;"""
    shank_radius: Annotated[NotNegative, Unit("m")] = ScaledDefault(0.025)
    """of it there, with what is to be free."""
    cop_reach: Annotated[NotNegative, Unit("m")] = ScaledDefault(0.05)
    """Of the planned centre of pressure from the middle of a foot, where ground is known."""
    rise_max: Annotated[Positive, Unit("m")] = ScaledDefault(0.2)
    """Of a step on known ground, up or down."""
    final_step_tolerance: Annotated[Positive, Unit("m")] = ScaledDefault(0.04)
    """Of the foothold, to end a walk beside the stance foot."""
    flight: Annotated[NotNegative, Unit("s")] | None = None
    """Between two steps, of a run at any speed; 0: it walks at any; null: the speed chooses."""
    run_above: Annotated[NotNegative, Unit("m/s")] = ScaledDefault(1.3)
    """It runs from the first touchdown at a command that is faster,"""
    walk_below: Annotated[NotNegative, Unit("m/s")] = ScaledDefault(1.1)
    """and walks again from the first at one that is slower."""
    run_flight: TickOrMore = ScaledDefault(0.06)
    """Between two steps, of a run that the speed has chosen."""
    run_step: TickOrMore = ScaledDefault(0.17)
    """From a touchdown to the next in a run: a stance and a flight."""
    run_width: Annotated[NotNegative, Unit("m")] = ScaledDefault(0.12)
    """Between the feet in a run."""
    run_height: Annotated[Positive, Unit("m")] = ScaledDefault(0.62)
    """Of the CoM above the ground where a foot lands or is lifted in a run."""
    run_ahead: Annotated[Number, Unit("m")] = ScaledDefault(0.03)
    """The middle of a contact is so far ahead of where its force is planned to be in a run."""
    run_trail: Annotated[Positive, Unit("m")] = ScaledDefault(0.13)
    """So far at most a contact stays behind the CoM until it is lifted in a run."""
    run_swing_height: Annotated[Positive, Unit("m")] = ScaledDefault(0.10)
    """Apex of a swing in a run."""
    run_late: Annotated[NotNegative, Unit("s")] = ScaledDefault(0.004)
    """A foot that ends a flight and finds no ground counts as standing so soon."""
    toe_off: Annotated[NotNegative, Le(0.5), Unit("rad")] = 0.0
    """So far a foot pitches on its toe after it is lifted in a walk."""
    arm_swing: Annotated[NotNegative, Unit("rad/m")] = ScaledDefault(0.5)
    """The arm goes ahead by so much for how far the foot of the other side does."""
    first_swing: Annotated[str, one_of(("left", "right"))] = "right"
    """Foot that makes the first step, "left" or "right"."""

    @together
    def _is_firm(self) -> None:
        if self.friction_firm <= self.friction_careful:
            allowed = f"must be above friction_careful = {self.friction_careful}"
            raise misfit("friction_firm", self.friction_firm, allowed)

    @together
    def _steps_last(self) -> None:
        still = self.settle_time + self.freeze_time
        for name in ("single_support", "single_support_min"):
            value = getattr(self, name)
            if value <= still:
                raise misfit(name, value, f"must be above settle_time + freeze_time = {still:g}")
