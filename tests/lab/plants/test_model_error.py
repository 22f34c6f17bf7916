import numpy as np
import pytest

from drake_linefoot.errors import ScenarioError
from drake_linefoot.lab.plants.scene import leg_bodies
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import ErrorParameters
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop


def plant_with(error):
    """The simulated plant with an error, its context at the start of a run, and its loop."""
    loop = build_closed_loop(Scenario(error=error))
    simulator = loop.make_simulator()
    plant = loop.plant.system
    return plant, plant.GetMyContextFromRoot(simulator.get_context()), loop, simulator


@pytest.fixture(scope="module")
def nominal():
    return plant_with(ErrorParameters())


def test_the_torso_gets_heavier_and_the_controller_does_not_know(nominal):
    plant, context, loop, _ = plant_with(ErrorParameters(torso_mass=3.0))
    mass = nominal[0].CalcTotalMass(nominal[1])
    assert plant.CalcTotalMass(context) == pytest.approx(mass + 3.0, abs=1e-12)
    assert loop.humanoid.mass == pytest.approx(mass, abs=1e-12)
    torso = plant.GetBodyByName("torso")
    before = torso.default_spatial_inertia()
    after = torso.CalcSpatialInertiaInBodyFrame(context)
    share = after.get_mass() / before.get_mass()
    np.testing.assert_allclose(after.get_com(), before.get_com(), atol=1e-15)
    np.testing.assert_allclose(
        after.CopyToFullMatrix6(), share * before.CopyToFullMatrix6(), atol=1e-12
    )


def test_legs_are_scaled_and_nothing_else(nominal):
    plant, context, loop, _ = plant_with(ErrorParameters(leg_mass_scale=1.1))
    legs = {body.name() for body in leg_bodies(plant, loop.humanoid)}
    assert {foot.frame for foot in loop.humanoid.description.feet} <= legs and "torso" not in legs
    added = 0.0
    for index in plant.GetBodyIndices(plant.GetModelInstanceByName("mit_humanoid")):
        body = plant.get_body(index)
        share = 1.1 if body.name() in legs else 1.0
        before, after = body.default_mass(), body.get_mass(context)
        assert after == pytest.approx(share * before, abs=1e-12), body.name()
        added += after - before
        np.testing.assert_allclose(
            body.CalcSpatialInertiaInBodyFrame(context).CopyToFullMatrix6(),
            share * body.default_spatial_inertia().CopyToFullMatrix6(),
            atol=1e-12,
        )
    total = nominal[0].CalcTotalMass(nominal[1])
    assert plant.CalcTotalMass(context) == pytest.approx(total + added, abs=1e-12)
    assert added > 0.5


def test_the_centre_of_mass_moves_by_the_torsos_share(nominal):
    offset = np.array([0.03, -0.01, 0.02])
    plant, context, _, _ = plant_with(ErrorParameters(torso_com=list(offset)))
    before = nominal[0].CalcCenterOfMassPositionInWorld(nominal[1])
    share = plant.GetBodyByName("torso").default_mass() / plant.CalcTotalMass(context)
    moved = plant.CalcCenterOfMassPositionInWorld(context) - before
    np.testing.assert_allclose(moved, share * offset, atol=1e-12)  # the torso is level
    torso = plant.GetBodyByName("torso")
    about = [
        inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
        for inertia in (
            torso.default_spatial_inertia(),
            torso.CalcSpatialInertiaInBodyFrame(context),
        )
    ]
    np.testing.assert_allclose(about[1], about[0], atol=1e-12)


def test_damping_brakes_every_joint(nominal):
    plant, context, loop, _ = plant_with(ErrorParameters(joint_damping=0.2))
    for name in loop.humanoid.description.actuated_joints:
        joint = plant.GetJointByName(name)
        added = joint.GetDampingVector(context) - joint.default_damping_vector()
        np.testing.assert_allclose(added, [0.2])


def test_a_torso_without_mass_is_refused(nominal):
    mass = -nominal[0].GetBodyByName("torso").default_mass()
    build_closed_loop(Scenario(error=ErrorParameters(torso_mass=mass + 0.1)))
    with pytest.raises(ScenarioError, match=r"error.torso_mass = .*: must be above -.* kg, the ma"):
        build_closed_loop(Scenario(error=ErrorParameters(torso_mass=mass)))


@pytest.mark.slow
@pytest.mark.parametrize(
    "error",
    [
        ErrorParameters(torso_mass=3.0),
        ErrorParameters(torso_mass=-3.0, leg_mass_scale=0.9),
        ErrorParameters(torso_com=[0.0, 0.02, 0.0], joint_damping=0.1),
    ],
    ids=["heavy", "light", "skew"],
)
def test_it_walks_with_another_body(error):
    segments = [Segment("stand", 0.3), Segment("walk", 2.0, True, [0.4, 0.0])]
    run = simulate(build_closed_loop(Scenario(segments=segments, error=error)))
    assert not run.fell, run.fall_reason
    assert run.com[-1, 0] > 0.3
