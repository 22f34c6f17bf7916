import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from drake_linefoot.drive.drive import Drive, status
from drake_linefoot.drive.pace import Pace
from drake_linefoot.drive.panel import BUTTONS, VELOCITIES, Panel
from drake_linefoot.drive.session import Session
from drake_linefoot.drive.teleop import Teleop, Tuning
from drake_linefoot.scenario import Scenario
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
