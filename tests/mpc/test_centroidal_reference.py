"""The reference of the MPC as a LeafSystem, through its ports only."""

import numpy as np
import pytest

from drake_linefoot.errors import SignalError
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.mpc.centroidal_reference import CentroidalReference
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.signals import Reference
from tests.helpers.ports import look, put
from tests.helpers.walking import dynamics_of, mirror_horizon, mirror_reference, recorded_walk


@pytest.fixture(scope="module")
def system(humanoid):
    return CentroidalReference(humanoid, MpcParameters(model="ecd"))


def fix(system, context, x, horizon):
    put(system, context, "dynamics", dynamics_of(x))
    put(system, context, "horizon", horizon)


def evaluate(system, x, horizon):
    context = system.CreateDefaultContext()
    fix(system, context, x, horizon)
    return look(system.get_reference_output_port(), context)


def assert_same(a, b, atol):
    for name, x, y in zip(Reference._fields, a, b, strict=True):
        np.testing.assert_allclose(x, y, atol=atol, rtol=0, err_msg=name)


def test_names_and_sizes_of_the_ports(humanoid, system):
    assert system.get_name() == "centroidal_reference"
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    assert [p.get_name() for p in inputs] == ["dynamics", "horizon"]
    assert system.num_output_ports() == 1
    assert system.get_reference_output_port().get_name() == "reference"
    assert system.num_continuous_states() == 0
    assert system.CreateDefaultContext().num_discrete_state_groups() == 0


def test_it_is_what_the_closed_loop_saw(system):
    for record in recorded_walk().mpc[::11]:
        assert_same(evaluate(system, record.x, record.horizon), record.reference, 1e-12)


def test_a_standing_robot_shall_stay_where_it_is(humanoid, system):
    """Known answer: nothing moves but the CoM's height, which goes to the commanded one."""
    horizon = recorded_walk().mpc[0].horizon
    ref = evaluate(system, humanoid.x_nominal, horizon)
    feet = horizon.feet[0]
    np.testing.assert_allclose(
        ref.r[-1], [*feet[:, :2].mean(axis=0), GaitParameters().com_height], atol=2e-3
    )
    np.testing.assert_allclose(ref.v, 0.0, atol=0.01)
    np.testing.assert_allclose(ref.Omega_mid, 0.0, atol=1e-15)
    np.testing.assert_allclose(ref.L_mid, 0.0, atol=0.01)
    np.testing.assert_array_equal(ref.contact, 1.0)
    assert ref.coming == 0.0


def test_mirrored_input_gives_mirrored_output(humanoid, system):
    for record in recorded_walk().mpc[5::13]:
        x, horizon = humanoid.mirror_state(record.x), mirror_horizon(record.horizon)
        assert_same(evaluate(system, x, horizon), mirror_reference(record.reference), 1e-6)


def test_time_alone_recomputes_nothing_and_a_new_state_does(humanoid, system, monkeypatch):
    calls, vector = [], ReferenceGenerator.vector

    def counted(self, *args):
        calls.append(args)
        return vector(self, *args)

    monkeypatch.setattr(ReferenceGenerator, "vector", counted)
    record = recorded_walk().mpc[40]
    context = system.CreateDefaultContext()
    fix(system, context, record.x, record.horizon)
    port = system.get_reference_output_port()
    first, made = look(port, context), len(calls)
    context.SetTime(0.123)
    look(port, context)
    assert len(calls) == made == 1
    x = record.x.copy()
    x[4] += 0.01
    fix(system, context, x, record.horizon)
    assert look(port, context).r[0, 0] == pytest.approx(first.r[0, 0] + 0.01, abs=1e-12)


@pytest.mark.parametrize("value", [np.nan, -np.inf])
def test_a_state_that_is_not_finite_is_refused_by_name(humanoid, system, value):
    context, d = system.CreateDefaultContext(), dynamics_of(humanoid.x_nominal)
    fix(system, context, humanoid.x_nominal, recorded_walk().mpc[0].horizon)
    v = d.v.copy()
    v[5] = value
    put(system, context, "dynamics", d._replace(v=v))
    with pytest.raises(SignalError, match=r"centroidal_reference\.dynamics: v\[5\]"):
        system.get_reference_output_port().Eval(context)


def test_a_horizon_that_is_not_finite_is_refused_by_name(humanoid, system):
    context, horizon = system.CreateDefaultContext(), recorded_walk().mpc[0].horizon
    fix(system, context, humanoid.x_nominal, horizon._replace(yaw=np.inf))
    with pytest.raises(SignalError, match=r"centroidal_reference\.horizon: yaw is inf"):
        system.get_reference_output_port().Eval(context)
