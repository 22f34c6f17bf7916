"""A robot that fell lies on the ground; a part of a drive is recorded."""

import numpy as np
import pytest

from drake_linefoot.lab.drive.drive import LOG, Clip
from drake_linefoot.lab.drive.session import Session
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.simulation.recording import Run


def test_a_robot_that_fell_lies_down_and_its_time_stands_still():
    session = Session(Scenario(), None, record=False)
    humanoid, loop = session.loop.humanoid, session.loop
    x = humanoid.x_nominal
    x[humanoid.nq + 1] = 3.0  # [rad/s] forward
    loop.plant.place(session._context, x)
    height, session.fall = x[6], "torso tilted"
    session.lie_down(3.0)
    assert session.time == 0.0
    q, v = session._ragdoll.state
    assert q[6] < 0.5 * height
    assert np.abs(v).max() < 0.5
    tree, robot = humanoid.plant, humanoid.base.model_instance()
    scratch = tree.CreateDefaultContext()
    tree.SetPositions(scratch, q)
    bodies = map(tree.get_body, tree.GetBodyIndices(robot))
    heights = [body.EvalPoseInWorld(scratch).translation()[2] for body in bodies]
    assert min(heights) > 0.0  # nothing sinks in
    assert max(heights) < height


def test_a_state_that_is_not_finite_stays_as_it_is():
    session = Session(Scenario(), None, record=False)
    humanoid = session.loop.humanoid
    session.fall = "state not finite"
    session.lie_down(0.01)
    ragdoll = session._ragdoll
    assert not ragdoll.fall(np.full(humanoid.nq, np.nan), np.zeros(humanoid.nv))


def test_a_clip_begins_at_zero_and_is_written(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(
        "drake_linefoot.lab.drive.drive.draw_replay", lambda *paths: drawn.append(paths)
    )
    session, clip = Session(Scenario(), None, record=False), Clip(tmp_path)
    session.advance(0.01)
    clip.toggle(session)
    session.advance(0.02)
    clip.toggle(session)
    clip._writing.join(60.0)
    assert (clip.note, len(drawn)) == ("", 1)
    run = Run.load(tmp_path / LOG)
    assert run.time[0] == 0.0
    assert run.time[-1] == pytest.approx(0.02, abs=2e-3)
    assert not session.clip
