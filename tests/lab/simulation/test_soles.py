"""A robot that touches with soles, from the simulator over logs to pictures and figures."""

import io
import json

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.axes import CORNERS, FEET, TAU_X
from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.lab.plants.initial_state import initial_state
from drake_linefoot.lab.plants.scene import add_plant
from drake_linefoot.lab.results.clearance import leg_clearance, limb_radius
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.results.pressure import pressure_plot, true_pressure, wanted_pressure
from drake_linefoot.lab.results.report import footstep_figure
from drake_linefoot.lab.scenario.load import make_scenario
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run_view import axis_names
from tests.helpers.recorded_runs import mcap_log
from tests.helpers.walk_on_soles import robot_on_soles, walk_on_soles

ROBOT, SCENARIO = robot_on_soles()
X, Y = ROBOT.half_length, ROBOT.half_width
AT = np.array([[-X, Y, 0.0], [-X, -Y, 0.0], [X, Y, 0.0], [X, -Y, 0.0]])  # corners from the middle


def corners_by_drake(q):
    """The corners of both soles [m], shape (2, 4, 3)."""
    plant = ROBOT.plant
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    feet = zip(ROBOT.foot_frames, ROBOT.p_FC, strict=True)
    return np.array([(f.CalcPoseInWorld(context) @ (p + AT).T).T for f, p in feet])


@pytest.fixture(scope="module")
def run():
    return walk_on_soles()


@pytest.fixture(scope="module")
def resting(run):
    """The last sample before the first step."""
    return int(np.flatnonzero(run.time > 0.75)[0])


def test_a_sphere_touches_at_each_corner():
    plant, graph, _ = add_plant(DiagramBuilder(), ROBOT, SCENARIO)
    inspector = graph.model_inspector()
    for frame, p_FC in zip(ROBOT.foot_frames, ROBOT.p_FC, strict=True):
        body = ROBOT.names_in(plant).body(frame.body().name())
        X_FB = frame.GetFixedPoseInBodyFrame().inverse()
        lowest = []
        for geometry in plant.GetCollisionGeometriesForBody(body):
            centre = X_FB @ inspector.GetPoseInFrame(geometry).translation()
            lowest.append(centre - [0.0, 0.0, inspector.GetShape(geometry).radius()])
        np.testing.assert_allclose(lowest, p_FC + AT, atol=1e-9)


def test_recorded_points_are_the_corners(run):
    for i in range(0, len(run.time), 300):
        np.testing.assert_allclose(run.contact_points[i], corners_by_drake(run.q[i]), atol=1e-6)


def test_the_points_bear_the_weight_below_the_centre_of_mass(run, resting):
    np.testing.assert_allclose(run.true_normal.sum(axis=2), run.true_force[..., 2], atol=1e-9)
    normal, points = run.true_normal[resting].ravel(), run.contact_points[resting].reshape(-1, 3)
    still = slice(resting - 100, resting)  # it breathes a little
    weight = run.true_normal[still].sum(axis=(1, 2)).mean()
    assert weight == pytest.approx(ROBOT.mass * STANDARD_GRAVITY, rel=0.01)
    middle = normal @ points / normal.sum()
    np.testing.assert_allclose(middle[:2], run.com[resting, :2], atol=5e-3)  # it sways a little


def test_where_it_presses_is_what_the_wrenches_say(run):
    """On the mean of a while, for sensors of torque are noisy."""
    stands = (run.time > 0.5) & (run.time < 0.8)
    true = true_pressure(run)[stands].mean(axis=0)
    np.testing.assert_allclose(wanted_pressure(run)[stands].mean(axis=0), true, atol=2e-3)
    wrench = run.contact_wrench[stands].mean(axis=0)
    np.testing.assert_allclose(wrench[:, TAU_X] / wrench[:, 2], true[:, 1], atol=3e-3)
    assert [panel.label for panel in pressure_plot(run).panels] == [
        f"{foot} foot, {way}" for foot in FEET for way in ("ahead", "left")
    ]


def test_it_steps_on_its_estimate(run):
    metrics = compute_metrics(run)
    assert not run.fell and metrics["solver_failures"] == {"mpc": 0, "wbc": 0}
    assert metrics["steps"] >= 1 and metrics["slip_m"] < 0.005
    assert all(0.0 <= share <= 1.0 for share in metrics["cop_at_edge"].values())
    settled = run.time > 0.5
    assert np.abs(run.estimate_pose - run.q[:, :7])[settled].max() < 0.01
    assert np.abs(run.estimate_velocity - run.v[:, :6])[settled, 3:].max() < 0.05
    stands = np.isfinite(run.estimate_nis[settled]).reshape(-1, 2, 2).any(axis=2)
    assert stands.any(axis=1).mean() > 0.95  # some foot holds it


def test_a_log_has_six_numbers_and_four_points_by_their_names(run, tmp_path):
    run.save(tmp_path / "log.arrow")
    again = Run.load(tmp_path)
    for name in ("contact_points", "true_normal", "contact_wrench", "mpc_wrench", "wbc_wrench"):
        np.testing.assert_array_equal(getattr(again, name), getattr(run, name))
    assert axis_names(run)["nc"] == CORNERS
    reader = make_reader(io.BytesIO(mcap_log(run)))
    for _, channel, message in reader.iter_messages(topics=["/true_normal", "/contact_wrench"]):
        said = json.loads(message.data)["right"]
        names = CORNERS if channel.topic == "/true_normal" else said.keys() | {"tau_x"}
        assert set(said) == set(names)


def test_arrows_and_footholds_of_a_scene_have_the_size_of_soles(run, resting):
    found = {}
    reader = make_reader(io.BytesIO(mcap_log(run)), decoder_factories=[DecoderFactory()])
    topics = ["/scene/forces", "/scene/footholds"]
    for _, channel, message, decoded in reader.iter_decoded_messages(topics=topics):
        found.setdefault(channel.topic, []).append((1e-9 * message.log_time, decoded))
    time, message = min(found["/scene/forces"], key=lambda m: abs(m[0] - run.time[resting]))
    begins = [a.pose.position for a in message.entities[0].arrows]
    assert len(begins) == 8
    corners = corners_by_drake(run.q[int(np.argmin(np.abs(run.time - time)))]).reshape(-1, 3)
    np.testing.assert_allclose([[p.x, p.y, p.z] for p in begins], corners, atol=1e-6)
    size = found["/scene/footholds"][0][1].entities[0].cubes[0].size
    np.testing.assert_allclose([size.x, size.y], [2.0 * X, 2.0 * Y])


def test_a_step_from_above_is_the_outline_of_a_sole(run):
    left = next(trace for trace in footstep_figure(run).data if trace.name == "left foot")
    outline = np.column_stack([left.x, left.y])[:5]
    np.testing.assert_array_equal(outline[0], outline[-1])
    edges = np.linalg.norm(np.diff(outline, axis=0), axis=1)
    np.testing.assert_allclose(np.sort(edges), [2 * Y, 2 * Y, 2 * X, 2 * X], rtol=1e-3)


def test_legs_are_as_far_apart_as_their_soles():
    """Feet are the widest parts: capsules side by side."""
    p = corners_by_drake(ROBOT.q_nominal).mean(axis=1)
    wide = max(Y, limb_radius(ROBOT))
    gap = leg_clearance(ROBOT, ROBOT.q_nominal[None])[0]
    assert gap == pytest.approx(p[0, 1] - p[1, 1] - 2.0 * wide, abs=1e-4)


def test_a_perturbed_start_has_its_lowest_corner_on_the_ground():
    perturbed = {"perturbation": {"joint_position": 0.03}, "robot": SCENARIO.robot, "seed": 3}
    q = initial_state(ROBOT, make_scenario(perturbed, "perturbed"))[: ROBOT.nq]
    corners = corners_by_drake(q)
    assert corners[..., 2].min() == pytest.approx(0.0, abs=1e-9)
    assert np.ptp(corners[0, :, 2]) > 1e-3  # it is tilted
