"""A robot like the MIT Humanoid in everything but its size, and runs of it."""

import re
from dataclasses import replace

import numpy as np

from drake_linefoot.lab.scenario import PlantParameters, Segment
from drake_linefoot.lab.simulation.recording import CHANNELS
from drake_linefoot.resources import models_dir
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robot.scaling import scaled, unit_value
from tests.helpers.walking import robot

LENGTH, MASS = 0.25, 0.07  # of the similar robot, in those of the MIT Humanoid
TIME = LENGTH**0.5  # both fall alike


def scaled_numbers(text, attribute, factor):
    """Multiply the numbers of an attribute of a URDF."""
    return re.sub(
        rf'(?<= {attribute}=")[^"]*',
        lambda m: " ".join(repr(factor * float(number)) for number in m[0].split()),
        text,
    )


def similar_robot(folder):
    """Return the MIT Humanoid made of other stuff and a quarter as high."""
    model = models_dir() / "mit_humanoid"
    urdf = (model / "mit_humanoid.urdf").read_text(encoding="utf-8")
    urdf = re.sub(r"<(visual|collision).*?</\1>", "", urdf, flags=re.DOTALL)
    inertia = MASS * LENGTH**2
    for attribute, factor in (
        ("xyz", LENGTH), ("effort", MASS * LENGTH), ("velocity", 1.0 / TIME),
        ("ixx", inertia), ("ixy", inertia), ("ixz", inertia), ("iyy", inertia),
        ("iyz", inertia), ("izz", inertia),
    ):  # fmt: skip
        axes = re.findall(r"<axis [^>]*>", urdf)
        urdf = scaled_numbers(urdf, attribute, factor)
        for axis, changed in zip(axes, re.findall(r"<axis [^>]*>", urdf), strict=True):
            urdf = urdf.replace(changed, axis, 1)
    urdf = re.sub(r'<mass value="([^"]*)"', lambda m: f'<mass value="{MASS * float(m[1])!r}"', urdf)
    urdf = re.sub(
        r'(rotor_inertia value=")([^"]*)', lambda m: m[1] + repr(inertia * float(m[2])), urdf
    )
    (folder / "small.urdf").write_text(urdf, encoding="utf-8")
    text = (model / "mit_humanoid.yaml").read_text(encoding="utf-8")
    text = text.replace("mit_humanoid.urdf", "small.urdf")
    for name, value in re.findall(r"^  (\w+): +([\d.]+) .*\[m\]", text, re.MULTILINE):
        text = re.sub(rf"(  {name}: +){value}", rf"\g<1>{LENGTH * float(value)}", text)
    points = [
        [LENGTH * float(x) for x in point] for point in robot().description.feet[0].contact_points
    ]
    text = re.sub(r"contact_points: \[\[.*?\]\]", f"contact_points: {points}", text)
    (folder / "small.yaml").write_text(text, encoding="utf-8")
    return folder / "small.yaml"


def similar_run(run, file):
    """Return what a similar robot would have recorded, moving alike.

    Args:
        run: of the MIT Humanoid.
        file: of the robot, from `similar_robot`.
    """
    base = {"m": LENGTH, "s": TIME, "kg": MASS, "N": MASS, "rad": 1.0, "ms": 1.0}
    arrays = {}
    for name, channel in CHANNELS.items():
        values = getattr(run, name)
        count = values.shape[-1] if values.ndim > 1 else 1
        factors = [unit_value(unit, base) for unit in channel.entry_units(count)]
        arrays[name] = values * (factors if values.ndim > 1 else factors[0])
    segments = [
        Segment(s.name, TIME * s.duration, s.walk, speeds.tolist(), s.turn_rate / TIME)
        for s in run.scenario.segments
        for speeds in [np.array(s.velocity) * LENGTH / TIME]
    ]
    scenario = replace(
        run.scenario,
        robot=str(file),
        segments=segments,
        gait=scaled(run.scenario.gait, load_humanoid(file)),
        plant=PlantParameters(time_step=TIME * run.scenario.plant.time_step),
    )
    return replace(
        run,
        scenario=scenario,
        effort_limits=run.effort_limits * MASS * LENGTH,
        fall_time=None if run.fall_time is None else TIME * run.fall_time,
        **arrays,
    )
