"""A robot that fell lies on the ground."""

import numpy as np

from drake_linefoot.drive.session import Session
from drake_linefoot.scenario import Scenario


def test_a_robot_that_fell_lies_down_and_its_time_stands_still():
    session = Session(Scenario(), None, record=False)
    session.push([600.0, 0.0])
    session.advance(2.0)
    assert session.fall
    time, height = session.time, session.last("q")[6]
    session.lie_down(3.0)
    limp, plant = session._limp, session._limp._plant
    assert session.time == time
    assert limp.q[6] < 0.6 * height
    v = plant.GetVelocities(limp._context)
    assert np.abs(v[3:6]).max() < 0.3
    humanoid = session.loop.humanoid
    tree, robot = humanoid.plant, humanoid.base.model_instance()
    context = tree.CreateDefaultContext()
    tree.SetPositions(context, limp.q)
    bodies = map(tree.get_body, tree.GetBodyIndices(robot))
    heights = [body.EvalPoseInWorld(context).translation()[2] for body in bodies]
    assert min(heights) > -0.02  # nothing sinks in
    assert max(heights) < height
    session.reset()
    session.advance(0.1)
    assert not session.fall
