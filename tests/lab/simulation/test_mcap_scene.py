"""The scene in the MCAP log, read with the public reader and its decoder of protobuf."""

import io

import numpy as np
import pytest
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Box, Capsule, Cylinder, Ellipsoid, Rgba, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from drake_linefoot.errors import InputError
from drake_linefoot.lab.simulation.mcap_scene import add_shape
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers.recorded_runs import make_run, mcap_log, short_run

KINDS = {
    "/tf": "foxglove.FrameTransforms",
    "/scene/robot": "foxglove.SceneUpdate",
    "/scene/forces": "foxglove.SceneUpdate",
    "/scene/plan": "foxglove.SceneUpdate",
    "/scene/footholds": "foxglove.SceneUpdate",
}


def scene_of(run):
    """Time [s] and message of every topic of the scene, and the schema of each."""
    reader = make_reader(io.BytesIO(mcap_log(run)), decoder_factories=[DecoderFactory()])
    found, kinds = {}, {}
    for schema, channel, message, decoded in reader.iter_decoded_messages(topics=list(KINDS)):
        kinds[channel.topic] = schema.name
        found.setdefault(channel.topic, []).append((1e-9 * message.log_time, decoded))
    return found, kinds


@pytest.fixture(scope="module")
def scene():
    return scene_of(short_run())


def pose(position, orientation):
    q = orientation
    R = RotationMatrix(Quaternion(np.array([q.w, q.x, q.y, q.z])))
    return RigidTransform(R, [position.x, position.y, position.z])


def row_at(run, time):
    return int(np.argmin(np.abs(run.time - time)))


def test_topics_have_foxgloves_schemas_and_32_messages_a_second(scene):
    found, kinds = scene
    assert kinds == KINDS
    for topic in ("/tf", "/scene/forces", "/scene/plan"):
        times = [time for time, _ in found[topic]]
        np.testing.assert_allclose(times, np.arange(len(times)) / 32.0, atol=1e-3)
        assert times[-1] > short_run().time[-1] - 0.04
    assert [time for time, _ in found["/scene/robot"]] == [0.0]


def test_every_body_is_where_the_recorded_state_puts_it(scene):
    run, (found, _) = short_run(), scene
    plant = load_humanoid("mit_humanoid").plant
    context = plant.CreateDefaultContext()
    for time, message in found["/tf"]:
        plant.SetPositions(context, run.q[row_at(run, time)])
        assert len(message.transforms) >= plant.num_bodies() - 1
        for each in message.transforms:
            assert each.parent_frame_id == "world"
            body = plant.GetBodyByName(each.child_frame_id)
            X = plant.EvalBodyPoseInWorld(context, body)
            assert X.IsNearlyEqualTo(pose(each.translation, each.rotation), 1e-9)


def test_the_robot_has_the_shape_of_its_meshes_and_the_ground_is_there(scene):
    run, (found, _) = short_run(), scene
    entities = {each.id: each for each in found["/scene/robot"][0][1].entities}
    frames = {each.child_frame_id: each for each in found["/tf"][0][1].transforms}
    assert all(each.frame_id == name and each.frame_locked for name, each in entities.items())
    assert set(entities) == {"world", *frames}
    assert [cube.size.x for cube in entities["world"].cubes] == [20.0]
    points = []
    for name, each in frames.items():
        for mesh in entities[name].triangles:
            assert len(mesh.indices) % 3 == 0 and max(mesh.indices) < len(mesh.points)
            X = pose(each.translation, each.rotation) @ pose(
                mesh.pose.position, mesh.pose.orientation
            )
            points.append((X @ np.array([[p.x, p.y, p.z] for p in mesh.points]).T).T)
    points = np.vstack(points)
    low, high = points.min(axis=0), points.max(axis=0)
    assert -0.02 < low[2] < 0.03 and 0.9 < high[2] < 1.2  # it stands on the ground
    assert low[0] < run.q[0, 4] < high[0] and low[1] < -0.1 and high[1] > 0.1


def test_arrows_carry_the_weight_and_begin_at_heel_and_toe(scene):
    run, (found, _) = short_run(), scene
    time, message = found["/scene/forces"][1]  # it stands on both feet
    i, (entity,) = row_at(run, time), message.entities
    forces = []
    for arrow in entity.arrows:
        X = pose(arrow.pose.position, arrow.pose.orientation)
        forces.append(
            400.0 * (arrow.shaft_length + arrow.head_length) * X.rotation().matrix()[:, 0]
        )
        distances = np.linalg.norm(run.contact_points[i] - X.translation(), axis=-1)
        assert distances.min() < 1e-9
    assert len(forces) == 4
    np.testing.assert_allclose(np.sum(forces, axis=0), run.true_force[i].sum(axis=0), atol=1e-6)


def test_plan_and_footholds_are_those_of_the_run(scene):
    run, (found, _) = short_run(), scene
    time, message = found["/scene/plan"][-1]
    i, (entity,) = row_at(run, time), message.entities
    com, *ahead = [
        [s.pose.position.x, s.pose.position.y, s.pose.position.z] for s in entity.spheres
    ]
    np.testing.assert_allclose(com, run.com[i])
    np.testing.assert_allclose(ahead, run.mpc_horizon[i])
    planned = [[c.pose.position.x, c.pose.position.y] for c in entity.cubes]
    known = run.mpc_footholds[i][np.isfinite(run.mpc_footholds[i]).all(axis=1)]
    assert len(planned) > 0
    np.testing.assert_allclose(planned, known[:, :2])
    time, message = found["/scene/footholds"][0]
    places = [[c.pose.position.x, c.pose.position.y] for c in message.entities[0].cubes]
    np.testing.assert_allclose(places, run.contact_points[0].mean(axis=1)[:, :2])


@pytest.mark.parametrize(
    ("shape", "spheres", "others"),
    [
        (Box(1, 2, 3), [], {"cubes": [1, 2, 3]}),
        (Sphere(0.5), [[1, 1, 1]], {}),
        (Ellipsoid(1, 2, 3), [[2, 4, 6]], {}),
        (Cylinder(0.5, 3), [], {"cylinders": [1, 1, 3]}),
        (Capsule(0.5, 3), [[1, 1, 1], [1, 1, 1]], {"cylinders": [1, 1, 3]}),
    ],
)
def test_shapes_other_than_meshes_have_their_sizes(shape, spheres, others):
    entity = SceneEntity()
    add_shape(entity, shape, RigidTransform([1.0, 0.0, 0.0]), Rgba(0.1, 0.2, 0.3, 0.4))
    for kind, expected in {"cubes": None, "cylinders": None, **others}.items():
        found = [[each.size.x, each.size.y, each.size.z] for each in getattr(entity, kind)]
        assert found == ([] if expected is None else [expected])
    assert [[each.size.x, each.size.y, each.size.z] for each in entity.spheres] == spheres
    for each in [*entity.cubes, *entity.cylinders, *entity.spheres]:
        assert each.pose.position.x == 1.0 and each.color.a == 0.4


def test_a_robot_that_is_another_one_now_is_refused():
    run = make_run(np.zeros(1), q=np.ones((1, 20)))
    with pytest.raises(InputError, match=r"not the .* of the recording"):
        mcap_log(run)
