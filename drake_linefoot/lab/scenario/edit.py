"""Changes to a scenario: another length, another command."""

from dataclasses import replace

from drake_linefoot.lab.scenario.schema import Scenario, Segment

STAND = 1.0  # [s] before a constant command


def with_duration(scenario: Scenario, duration: float) -> Scenario:
    """Return a scenario that stops earlier, or holds its last segment for longer.

    Args:
        scenario: what to change; it stays as it is.
        duration: of the new one [s], positive.
    """
    segments: list[Segment] = []
    left = duration
    for segment in scenario.segments:
        if left <= 0.0:
            break
        segments.append(replace(segment, duration=min(segment.duration, left)))
        left -= segment.duration
    if left > 0.0:
        segments[-1] = replace(segments[-1], duration=segments[-1].duration + left)
    return replace(scenario, segments=segments)


def with_command(
    scenario: Scenario, vx: float, vy: float, turn: float, stand: float = STAND
) -> Scenario:
    """Return a scenario that stands for a while and then walks with one command.

    Args:
        scenario: what to change; it stays as it is. Its length is kept.
        vx: forward velocity [m/s].
        vy: velocity to the left [m/s].
        turn: turn rate, counter-clockwise positive [rad/s].
        stand: how long it stands [s].
    """
    segments = [
        Segment("stand", duration=stand),
        Segment("walk", duration=STAND, walk=True, velocity=[vx, vy], turn_rate=turn),
    ]
    return with_duration(replace(scenario, segments=segments), scenario.duration)


def warnings_of(scenario: Scenario) -> list[str]:
    """Return what somebody who gave a command or a duration would not expect of the run."""
    gait, said = scenario.gait, list[str]()
    ahead = min(gait.forward_max, gait.walk_max) if gait.flight == 0.0 else gait.forward_max
    for segment in scenario.segments:
        for what, value, most, unit in (
            ("forward", segment.velocity[0], ahead, "m/s"),
            ("left", segment.velocity[1], gait.lateral_max, "m/s"),
            ("turn", segment.turn_rate, gait.turn_max, "rad/s"),
        ):
            if abs(value) > most:
                limit = f"beyond the limit of {most:g} {unit} of the gait, at which it is cut"
                said.append(f"{segment.name}: {what} {value:g} {unit} is {limit}")
    walking = sum(segment.duration for segment in scenario.segments if segment.walk)
    if 0.0 < walking <= gait.shift_duration:
        first = f"its first step comes after {gait.shift_duration:g} s"
        said.append(f"too short to walk: {walking:g} s of walking, and {first}")
    return said
