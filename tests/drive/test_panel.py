import math

import msgpack
import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from drake_linefoot.drive.drive import Drive, status
from drake_linefoot.drive.pace import Pace
from drake_linefoot.drive.panel import (
    BUTTONS,
    COM_HEIGHT,
    FORCE,
    SINGLE_SUPPORT,
    SWING_HEIGHT,
    VELOCITIES,
    Panel,
)
from drake_linefoot.drive.session import Session
from drake_linefoot.drive.teleop import Teleop, Tuning
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robot.size import sized
from drake_linefoot.scenario import Scenario
from tests.helpers.similar import MASS, TIME, similar_robot
from tests.helpers.walking import robot

TUNING = Tuning(0.203, 0.06, 0.64, "ecd")


@pytest.fixture(scope="module")
def meshcat():
    return Meshcat(MeshcatParams(port=0))


def test_untouched_controls_say_what_is_in_force(meshcat):
    seen = Panel(meshcat, TUNING, robot()).read()
    assert seen.pressed == ()
    assert seen.lengths == (0.203, 0.06, 0.64)  # not what a slider rounds it to
    np.testing.assert_allclose(seen.velocity, np.zeros(3), atol=1e-12)
    assert seen.stick is None


def test_every_key_is_used_once(meshcat):
    keys = [key for _, key in BUTTONS.values() if key]
    keys += [key for *_, less, more in VELOCITIES for key in (less, more)]
    assert len(keys) == len(set(keys)) == 15


def test_sliders_are_read_and_moved(meshcat):
    panel = Panel(meshcat, TUNING, robot())
    panel.move_sliders(np.array([0.3, -0.1, 0.5]))
    np.testing.assert_allclose(panel.read().velocity, [0.3, -0.1, 0.5])
    panel.remove()
    assert meshcat.GetSliderNames() == []


def ends(meshcat, name):
    """Return the least and the largest value of a slider."""
    return [meshcat.SetSliderValue(name, value) for value in (-1e9, 1e9)]


def test_sliders_have_the_size_of_the_robot(meshcat, tmp_path):
    others = SINGLE_SUPPORT, SWING_HEIGHT, COM_HEIGHT, FORCE
    names = [slider[0] for slider in (*VELOCITIES, *others)]
    panel = Panel(meshcat, TUNING, robot())
    expected = [[-1, 1], [-0.4, 0.4], [-1, 1], [0.16, 0.32], [0.03, 0.12], [0.56, 0.68], [0, 200]]
    np.testing.assert_allclose([ends(meshcat, name) for name in names], expected, atol=1e-12)
    np.testing.assert_array_equal(panel.limits, [1.0, 0.4, 1.0])

    small = load_humanoid(similar_robot(tmp_path))
    gait, limits = sized(GaitParameters(), small), small.description.limits
    tuning = Tuning(gait.single_support, gait.swing_height, gait.com_height, "ecd")
    panel = Panel(meshcat, tuning, small)
    found = [ends(meshcat, name) for name in names]
    expected = [
        [-0.5, 0.5], [-0.2, 0.2], [-2, 2], [0.08, 0.16], [0.008, 0.03],
        [limits.com_height_min, limits.com_height_max], [0, 200.0 * MASS * TIME],
    ]  # fmt: skip
    np.testing.assert_allclose(found, expected, atol=1e-12)
    most = [gait.forward_max, gait.lateral_max, gait.turn_max]
    assert (panel.limits <= most).all()
    assert found[3][0] >= gait.single_support_min


def send(meshcat, **message):
    meshcat._InjectWebsocketMessage(msgpack.packb({"name": "", **message}))


def test_numbers_of_a_page_are_kept_within_the_sliders(meshcat):
    panel, speed = Panel(meshcat, TUNING, robot()), VELOCITIES[0][0]
    send(meshcat, type="slider", name=speed, value=0.5)
    assert panel.read().velocity[0] == 0.5
    for value in (math.nan, math.inf, -math.inf):
        send(meshcat, type="slider", name=speed, value=value)
        assert panel.read().velocity[0] == 0.5
    for value in (1e300, -1e300):
        for name in (speed, FORCE[0], SINGLE_SUPPORT[0], COM_HEIGHT[0]):
            send(meshcat, type="slider", name=name, value=value)
        seen, top = panel.read(), value > 0.0
        assert seen.velocity[0] == (1.0 if top else -1.0)
        assert seen.force == (200.0 if top else 0.0)
        assert seen.lengths[0] == pytest.approx(0.32 if top else 0.16, abs=0.01)
        assert seen.lengths[2] == pytest.approx(0.68 if top else 0.56, abs=0.005)


def test_a_stick_reaches_no_further_than_it_can(meshcat):
    panel = Panel(meshcat, TUNING, robot())
    pad = {"index": 0, "button_values": [], "axes": [-1e300, math.nan, 0.5]}
    send(meshcat, type="gamepad", gamepad=pad)
    np.testing.assert_array_equal(panel.read().stick, [0.0, 1.0, -0.5])
    send(meshcat, type="gamepad", gamepad={})
    assert panel.read().stick is None


def test_lines_are_replaced(meshcat):
    panel = Panel(meshcat, TUNING, robot())
    panel.show(["one", "two", "two"])
    assert meshcat.GetButtonClicks("two") == 0
    panel.show(["two", "three"])
    with pytest.raises(RuntimeError, match="one"):
        meshcat.GetButtonClicks("one")


def test_status_names_rate_speed_contact_solver_and_fall():
    session = Session(Scenario(), None, record=False)
    orders = Teleop(TUNING, (1, 1, 1)).update(
        Panel(Meshcat(MeshcatParams(port=0)), TUNING, robot()).read(), 0.0
    )
    session.advance(0.2)
    pace = Pace()
    pace.rate = 0.5
    lines = status(session, orders, pace)
    assert lines[0] == "0.2 s, 0.50 x real time, too slow"
    assert "on ground: left right" in lines
    assert "ECD: solved, 0 failed" in lines
    assert max(map(len, lines)) < 40
    session.push([900.0, 0.0])
    session.advance(2.0)
    said = status(session, orders, pace)
    assert said[-2] == "The robot FELL. R: begin again"
    assert said[-1] == session.fall != ""


def test_a_drive_ends_by_itself_and_says_its_rate(meshcat):
    said = []
    session = Drive(Scenario(), meshcat, record=True, say=said.append).run(1.6)
    assert 0.1 < session.time < 1.8
    assert any("x real time" in line for line in said[-1])
    assert session.run().time[-1] == pytest.approx(session.time, abs=2e-3)
    assert meshcat.HasPath("/drake/visualizer/mit_humanoid/torso")
    assert meshcat.GetSliderNames() == []
