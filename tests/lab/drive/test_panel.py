import json
from dataclasses import replace

import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.drive.drive import Drive
from drake_linefoot.lab.drive.panel import COM_HEIGHT, FORCE, SINGLE_SUPPORT, Panel
from drake_linefoot.lab.drive.session import Session
from drake_linefoot.lab.drive.telemetry import Pace, lines, rate_of, state
from drake_linefoot.lab.drive.teleop import ESTIMATE, Teleop, Tuning
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.disturbances import SensorParameters
from drake_linefoot.lab.visualization.controls import page_setup
from drake_linefoot.mpc.models.ecd import ECD
from drake_linefoot.mpc.models.registry import MODELS
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robot.scaling import scaled
from tests.helpers.driven import fake_live
from tests.helpers.similar import MASS, TIME, similar_robot
from tests.helpers.walking import robot

TUNING = Tuning(0.203, 0.06, 0.64, "ecd")


@pytest.fixture
def panel():
    return Panel(TUNING, robot())


def test_untouched_controls_say_what_is_in_force(panel):
    seen = panel.read([])
    assert seen.pressed == ()
    assert seen.lengths == (0.203, 0.06, 0.64)  # not what a slider rounds it to
    np.testing.assert_array_equal(seen.velocity, np.zeros(3))
    assert (seen.stick, seen.pull, seen.speed) == (None, None, 1.0)


def test_every_key_is_used_once(panel):
    keys = [button.key for button in panel.buttons.values() if button.key]
    keys += [key for s in panel.sliders.values() for key in (s.less, s.more) if key]
    assert len(keys) == len(set(keys)) == 17


def test_what_is_pressed_all_the_time_is_seen_and_what_is_rare_is_folded(panel):
    seen = [name for name, b in panel.buttons.items() if not b.fold]
    assert seen == ["stop", "push", "reset", "pause"]
    seen = {name: s.steers for name, s in panel.sliders.items() if not s.fold}
    assert seen == {"forward": False, "left": True, "turn": True}  # forward speed stays


def test_sliders_are_read_and_moved(panel):
    panel.move_sliders(np.array([0.3, -0.1, 0.5]))
    np.testing.assert_array_equal(panel.read([]).velocity, [0.3, -0.1, 0.5])
    seen = panel.read([{"set": ["left", 0.2]}, {"press": "stop"}, {"press": "none"}])
    np.testing.assert_array_equal(seen.velocity, [0.3, 0.2, 0.5])
    assert seen.pressed == ("stop",)


def test_a_page_is_given_what_json_takes(panel):
    setup = page_setup("a drive", robot(), panel.sliders, panel.buttons)
    setup = json.loads(json.dumps(setup, allow_nan=False))
    assert {s["name"]: s["value"] for s in setup["sliders"]} == panel.values()
    assert [b["name"] for b in setup["buttons"]] == list(panel.buttons)


def test_every_model_has_a_button_and_one_of_ones_own_as_well(panel, own_models):
    own_models(replace(ECD, name="stop", title="my own"))  # named as an action is
    buttons = Panel(TUNING, robot()).buttons
    labels = {name: button.label for name, button in buttons.items()}
    assert "model stop" not in panel.buttons
    assert (labels["model stop"], labels["stop"]) == ("my own", "stop")
    assert labels["model srbm"] == "single rigid body"
    assert [name for name in labels if name.startswith("model ")] == [f"model {m}" for m in MODELS]
    assert list(buttons)[-1] == "quit"
    seen = Panel(TUNING, robot()).read([{"press": "model stop"}, {"press": "model none"}])
    assert seen.pressed == ("model stop",)
    orders = Teleop(TUNING, np.ones((2, 3))).update(seen, 0.0)
    assert orders.tuning == replace(TUNING, model="stop")


def ends(panel):
    """Return the least and the largest value of each slider but the speed."""
    found = []
    for name in list(panel.sliders)[:-1]:
        pair = []
        for value in (-1e6, 1e6):
            panel.read([{"set": [name, value]}])
            pair.append(panel.values()[name])
        found.append(pair)
    return found


def test_sliders_have_the_size_of_the_robot(panel, tmp_path):
    expected = [[-1, 2.6], [-0.4, 0.4], [-1, 1], [0.16, 0.32], [0.03, 0.12], [0.56, 0.68], [0, 200]]
    np.testing.assert_allclose(ends(panel), expected, atol=1e-12)
    np.testing.assert_allclose(panel.limits, [[-1.0, -0.4, -1.0], [2.6, 0.4, 1.0]])

    small = load_humanoid(similar_robot(tmp_path))
    gait, limits = scaled(GaitParameters(), small), small.description.limits
    tuning = Tuning(gait.single_support, gait.swing_height, gait.com_height, "ecd")
    panel = Panel(tuning, small)
    found = ends(panel)
    expected = [
        [-0.5, 1.3], [-0.2, 0.2], [-2, 2], [0.08, 0.16], [0.008, 0.03],
        [limits.com_height_min, limits.com_height_max], [0, 200.0 * MASS * TIME],
    ]  # fmt: skip
    np.testing.assert_allclose(found, expected, atol=1e-12)
    most = [gait.forward_max, gait.lateral_max, gait.turn_max]
    assert (np.abs(panel.limits) <= np.array(most) + 1e-9).all()
    assert found[3][0] >= gait.single_support_min


def test_numbers_of_a_page_are_kept_within_the_sliders(panel):
    for value in (1e6, -1e6):
        names = ("forward", FORCE[0], SINGLE_SUPPORT[0], COM_HEIGHT[0], "speed", "none")
        seen = panel.read([{"set": [name, value]} for name in names])
        top = value > 0.0
        assert seen.velocity[0] == pytest.approx(2.6 if top else -1.0)
        assert seen.force == (200.0 if top else 0.0)
        assert seen.lengths[0] == pytest.approx(0.32 if top else 0.16)
        assert seen.lengths[2] == pytest.approx(0.68 if top else 0.56)
        assert seen.speed == (1.0 if top else 0.1)


def test_keys_reach_the_speeds_of_a_run_and_the_gait_takes_all_of_them(panel):
    slider, gait = panel.sliders["forward"], scaled(GaitParameters(), robot())
    steps = (slider.largest - slider.least) / slider.step
    assert steps == pytest.approx(round(steps))
    assert gait.run_above < slider.largest <= gait.forward_max
    command = Teleop(TUNING, panel.limits).update(panel.read([{"stick": [1, 0, 0]}]), 0.0).command
    np.testing.assert_allclose(command, [slider.largest, 0.0, 0.0, 1.0])


def test_a_stick_is_held_until_it_is_taken_away(panel):
    np.testing.assert_array_equal(panel.read([{"stick": [0, 1, -0.5]}]).stick, [0.0, 1.0, -0.5])
    np.testing.assert_array_equal(panel.read([]).stick, [0.0, 1.0, -0.5])
    assert panel.read([{"stick": None}]).stick is None


def test_a_pointer_pulls_like_a_spring_with_no_more_than_the_largest_push(panel):
    np.testing.assert_allclose(panel.read([{"drag": [0.1, 0.0, -0.05]}]).pull, [20.0, 0.0, -10.0])
    np.testing.assert_allclose(panel.read([{"drag": [0.0, 1e6, 0.0]}]).pull, [0.0, 200.0, 0.0])
    assert panel.read([{"drag": None}]).pull is None


def test_status_names_rate_speed_contact_solver_and_fall(panel):
    session = Session(Scenario(), None, record=False)
    orders = Teleop(TUNING, np.ones((2, 3))).update(panel.read([]), 0.0)
    session.advance(0.2)
    pace = Pace()
    pace.rate = 0.5

    def now():
        return state(session.loop, session.time, rate_of(session, orders, pace), session.fall)

    said = lines(json.loads(json.dumps({**now(), "aim": orders.aim}, allow_nan=False)))
    assert said[0] == "0.2 s, 0.50 x real time, too slow"
    assert "on ground: left right" in said
    assert "contact-consistent: solved, 0 failed" in said
    assert "state: true" in said
    assert max(map(len, said)) < 40
    weight = session.loop.humanoid.mass * 9.81
    assert sum(now()["force"]) == pytest.approx(weight, rel=0.1)
    session.push([900.0, 0.0])
    session.advance(2.0)
    said = lines({**now(), "aim": orders.aim})
    assert said[-2] == "The robot FELL. R: begin again"
    assert said[-1] == session.fall != ""


def test_a_drive_ends_by_itself_and_says_its_rate(tmp_path):
    said, page = [], fake_live(Meshcat(MeshcatParams(port=0)), tmp_path)
    session = Drive(Scenario(), page, record=True, say=said.append).run(1.6)
    assert 0.1 < session.time < 1.8
    assert any("x real time" in line for line in said[-1])
    assert session.run().time[-1] == pytest.approx(session.time, abs=2e-3)
    assert page.meshcat.HasPath("/drake/visualizer/mit_humanoid/torso")
    assert page.link.shown["state"] == {"ended": True}


def test_the_button_of_the_estimate_switches_it_and_a_refusal_can_be_pressed_again(tmp_path):
    page, press = fake_live(Meshcat(MeshcatParams(port=0)), tmp_path), [{"press": ESTIMATE}]
    drive = Drive(Scenario(), page)
    page.link.ordered = press
    drive.run(0.1)
    assert drive.session.tuning.estimation
    assert page.meshcat.HasPath("/overlays/estimated robot")
    page.link.ordered = press
    drive.run(0.1)
    assert not drive.session.tuning.estimation

    noisy = Scenario(sensors=SensorParameters(velocity=1e-3))
    said = []
    drive = Drive(noisy, page, say=said.append)
    for _ in range(2):
        page.link.ordered, drive._remark = press, ""
        drive.run(0.3)
        assert not drive.session.tuning.estimation
        assert any(line.startswith("not changed: estimation") for line in said[-1])


def test_a_paused_drive_goes_on_by_single_steps(tmp_path):
    page = fake_live(Meshcat(MeshcatParams(port=0)), tmp_path)
    drive = Drive(Scenario(), page)
    page.link.ordered = [{"press": "pause"}, {"press": "step"}]
    drive.run(0.2)
    assert drive.session.time == pytest.approx(1 / 32)
