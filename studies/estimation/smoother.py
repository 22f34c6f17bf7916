"""`python -m studies.estimation.smoother`: GTSAM's least squares beside the filter.

All of a walk at once: poses, velocities, biases and points on the ground, every 10 ms, that agree
best with what the filter got, by its own noise. It knows what comes later, so it is about what can
be had of these measurements. What it leaves to the filter: which points hold, and when.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray
from pydrake.systems.framework import Context, DiagramBuilder, DiscreteValues
from scipy.spatial.transform import Rotation

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.estimation.estimate import Constants, leg_points, point_loads
from drake_linefoot.estimation.filter_state import (
    ACCELEROMETER_BIAS,
    GYRO_BIAS,
    POINTS,
    VELOCITY,
    filter_of,
)
from drake_linefoot.estimation.invariant_filter import sunk
from drake_linefoot.estimation.state_estimator import initial_sigma
from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.layout import Layout
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from drake_linefoot.signals import ContactEstimate
from studies.common.command import run
from studies.common.files import prepare, write_json, write_text
from studies.common.stamp import cpu_seconds, stamped
from studies.common.types import Array
from studies.estimation.walks import SETTLED, probe

JSON, PAGE = "smoother.json", "smoother.md"
STEP = 10  # ticks from one state of the smoother to the next
PLACED = 1e-5  # [rad], [m] of heading and place at the beginning, which define the frame
SEGMENTS = (
    Segment("stand", 1.0),
    Segment("left", 9.0, True, [0.6, 0.0], 0.2),
    Segment("right", 10.0, True, [0.6, 0.0], -0.2),
)
MEASURED = {  # key: what it says
    "tilt_rmse_deg": "roll and pitch, RMSE [deg]",
    "velocity_rmse": "velocity of the base, RMSE [m/s]",
    "drift_xy_m": "horizontal, at the end [m]",
    "drift_z_m": "height, at the end [m]",
    "drift_yaw_deg": "heading, at the end [deg]",
}
Motion = tuple[Rotation, Array, Array]  # R_WB, velocity [m/s] and place [m] of the base


class Tape(Block):
    """Keeps what a state estimator reads, in the update in which it reads it."""

    def __init__(self, humanoid: Humanoid, period: float) -> None:
        """Declare ports and event; `period` is the estimator's [s]."""
        super().__init__()
        self.rows: list[tuple[Array, Array, Any]] = []
        self._imu = self.DeclareVectorInputPort("imu", 6)
        self._encoders = self.DeclareVectorInputPort("encoders", humanoid.na)
        contact = Layout(ContactEstimate, humanoid.sizes)
        self._contact = self.signal_input("contact", contact)
        self.DeclareDiscreteState(1)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._update))

    def _update(self, context: Context, _: DiscreteValues) -> None:
        ports = self._imu, self._encoders, self._contact
        imu, encoders, contact = (port.Eval(context) for port in ports)
        self.rows.append((imu, encoders, self.layouts["contact"].open(contact)))


@dataclass(frozen=True)
class Instant:
    """What the filter knew after a tick, and the truth."""

    ticks: int  # that it had taken in
    found: Motion  # what it made of them
    true: Motion  # what is
    holds: NDArray[np.bool_]  # whether each point held, shape (POINTS,)
    load: Array  # mean normal force of each point, see `rates_of` [N], shape (POINTS,)


class Recording:
    """A walk on the estimate: what the filter read, what it made of it, and the truth."""

    def __init__(self, scenario: Scenario) -> None:
        """Walk.

        Raises:
            InputError: the robot fell.
        """
        self._humanoid = load_humanoid(scenario.robot)
        loop = build_closed_loop(scenario, extend=self._add_tape)
        assert loop.estimator is not None
        self.constants: Constants = loop.estimator.constants_in(
            loop.estimator.CreateDefaultContext()
        )
        self.initial_sigma = initial_sigma(scenario.onboard)
        self.instants: list[Instant] = []
        self._loop, self._looks = loop, 0
        found = simulate(loop, look=self._look)
        if found.fell:
            raise InputError("walk", "seed", scenario.seed, f"fell: {found.fall_reason}")

    def _add_tape(self, builder: DiagramBuilder, sources: Any) -> None:
        onboard = builder.GetSubsystemByName("onboard")
        ports = {name: onboard.GetOutputPort(name) for name in ("imu", "encoders")}
        self.tape = builder.AddSystem(Tape(self._humanoid, 1e-3))
        for name, port in (*ports.items(), ("contact", sources["contact"])):
            builder.Connect(port, self.tape.GetInputPort(name))

    def _look(self, root: Context) -> None:
        self._looks += 1
        if self._looks % STEP:
            return
        loop = self._loop
        assert loop.estimator is not None
        mine = loop.estimator.GetMyContextFromRoot(root)
        s = filter_of(mine.get_discrete_state(0).value().copy())
        x = loop.plant.state(root)
        v = x[loop.humanoid.nq :]
        true = Rotation.from_quat(x[:4], scalar_first=True), v[3:6], x[4:7]
        found = Rotation.from_matrix(s.R), s.v, s.p
        holds = (s.active > 0.5) & (s.since > self.constants.noise.settle)
        self.instants.append(Instant(len(self.tape.rows), found, true, holds, s.load.copy()))


def smoothed(recording: Recording) -> list[Motion]:
    """Return the motion at each instant, by all that was measured.

    Raises:
        LinefootError: there is no GTSAM.
    """
    gtsam = _gtsam()
    from gtsam.symbol_shorthand import B, V, X

    c, instants = recording.constants, recording.instants
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    sigmas, n = gtsam.noiseModel.Diagonal.Sigmas, c.noise
    noise, unbiased = _imu_noise(gtsam, c), gtsam.imuBias.ConstantBias()
    held: dict[int, int] = {}  # of each point the key where it was seen last
    ticks = instants[0].ticks
    for k, now in enumerate(instants):
        R, v, p = now.found
        values.insert(X(k), gtsam.Pose3(gtsam.Rot3(R.as_matrix()), p))
        values.insert(V(k), v)
        values.insert(B(k), unbiased)
        if k:
            motion = gtsam.PreintegratedCombinedMeasurements(noise, unbiased)
            for imu, *_ in recording.tape.rows[ticks : now.ticks]:
                motion.integrateMeasurement(imu[3:], imu[:3], c.period)
            keys = X(k - 1), V(k - 1), X(k), V(k), B(k - 1), B(k)
            graph.add(gtsam.CombinedImuFactor(*keys, motion))
        ticks = now.ticks
        points, load = _points(recording, now)
        for i in range(POINTS):
            if not now.holds[i]:
                held.pop(i, None)
                continue
            here, far = gtsam.symbol("defg"[i], k), float(np.linalg.norm(points[i]))
            values.insert(here, p + R.apply(points[i]))
            seen = gtsam.Unit3(points[i]), far, sigmas(n.point * np.array([1 / far, 1 / far, 1.0]))
            graph.add(gtsam.BearingRangeFactor3D(X(k), here, *seen))
            if i in held:
                slip = n.slip * (1.0 + n.full / max(load[i], 1e-3 * n.full))
                still = sigmas(np.full(3, slip * np.sqrt(STEP * c.period)))
                graph.add(gtsam.BetweenFactorPoint3(held[i], here, np.zeros(3), still))
            held[i] = here
    first, d = instants[0].found, recording.initial_sigma
    pose = gtsam.Pose3(gtsam.Rot3(first[0].as_matrix()), first[2])
    placed = sigmas(np.concatenate([d[:2], np.full(4, PLACED)]))
    graph.add(gtsam.PriorFactorPose3(X(0), pose, placed))
    graph.add(gtsam.PriorFactorVector(V(0), np.zeros(3), sigmas(d[VELOCITY : VELOCITY + 3])))
    offsets = np.concatenate([d[ACCELEROMETER_BIAS:], d[GYRO_BIAS:ACCELEROMETER_BIAS]])
    graph.add(gtsam.PriorFactorConstantBias(B(0), unbiased, sigmas(offsets)))
    best = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    poses = [best.atPose3(X(k)) for k in range(len(instants))]
    return [
        (Rotation.from_matrix(pose.rotation().matrix()), best.atVector(V(k)), pose.translation())
        for k, pose in enumerate(poses)
    ]


def _gtsam() -> Any:
    try:
        import gtsam
    except ImportError as error:
        raise LinefootError(f"{error}; pip install 'drake_linefoot[smoother]'") from error
    return gtsam


def _imu_noise(gtsam: Any, c: Constants) -> Any:
    """Return what GTSAM is given of the IMU's noise."""
    noise, n = gtsam.PreintegrationCombinedParams.MakeSharedU(STANDARD_GRAVITY), c.noise
    noise.setGyroscopeCovariance(n.gyro**2 * np.eye(3))
    noise.setAccelerometerCovariance(n.accelerometer**2 * np.eye(3))
    noise.setBiasOmegaCovariance(n.gyro_walk**2 * np.eye(3))
    noise.setBiasAccCovariance(n.accelerometer_walk**2 * np.eye(3))
    noise.setIntegrationCovariance(1e-10 * np.eye(3))
    return noise


def _points(recording: Recording, now: Instant) -> tuple[Array, Array]:
    """Return the points in B as they would be without load [m], and their loads [N]."""
    c, (_, encoders, contact) = recording.constants, recording.tape.rows[now.ticks - 1]
    load = point_loads(contact.wrench, contact.contact, c.half_length, c.half_width)
    rates = (load - now.load) / (c.noise.change - c.period)  # the means are those after the tick
    deep = [sunk(*of, c.noise) for of in zip(load, rates, strict=True)]
    return leg_points(encoders, c)[0] + np.outer(deep, now.found[0].as_matrix()[2]), load


def measured(instants: Sequence[Instant], found: Sequence[Motion]) -> dict[str, float]:
    """Return the numbers of `MEASURED` of a motion that was found."""
    turns = np.array(
        [(R * now.true[0].inv()).as_rotvec() for (R, *_), now in zip(found, instants, strict=True)]
    )
    off = np.array(
        [(v - now.true[1], p - now.true[2]) for (_, v, p), now in zip(found, instants, strict=True)]
    )
    settled = np.arange(1, len(instants) + 1) * STEP * 1e-3 > SETTLED
    return {
        "tilt_rmse_deg": float(np.degrees(np.sqrt(np.mean(turns[settled, :2] ** 2)))),
        "velocity_rmse": float(np.sqrt(np.mean(np.sum(off[settled, 0] ** 2, axis=1)))),
        "drift_xy_m": float(np.linalg.norm(off[-1, 1, :2])),
        "drift_z_m": float(abs(off[-1, 1, 2])),
        "drift_yaw_deg": float(np.degrees(abs(turns[-1, 2]))),
    }


def smoother(
    out: Annotated[Path, typer.Option(help="Folder of the page.")] = Path("docs/estimation"),
    seeds: Annotated[int, typer.Option(min=1, help="Of every number.")] = 10,
) -> None:
    """Walk on the estimate and solve for the whole walk; write smoother.md and smoother.json."""
    command = f"python -m studies.estimation.smoother --seeds {seeds}"
    _gtsam()  # before anything is walked
    prepare(out)
    rows: list[dict[str, dict[str, float]]] = []
    for seed in range(seeds):
        walk = Recording(Scenario(seed=seed, estimation=True, segments=list(SEGMENTS)))
        best = smoothed(walk)
        ours = [now.found for now in walk.instants]
        of = {"filter": ours, "smoother": best}
        rows.append({name: measured(walk.instants, found) for name, found in of.items()})
    summary = {
        name: {
            key: float(np.sqrt(np.mean([row[name][key] ** 2 for row in rows]))) for key in MEASURED
        }
        for name in rows[0]
    }
    about = {"seeds": seeds, "command": command, **stamped("estimation", cpu_seconds(), probe)}
    write_json(out / JSON, {**summary, **about, "walks": rows})
    page = render("smoother.md.j2", Path(__file__).parent, **about, **summary, measured=MEASURED)
    write_text(out / PAGE, page)
    typer.echo(str(out / PAGE))


if __name__ == "__main__":
    sys.exit(run(smoother, "estimation.smoother"))
