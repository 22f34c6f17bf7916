"""The condensed program against step-by-step rollouts and finite differences."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import expm
from scipy.optimize import nnls
from scipy.spatial.transform import Rotation

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.contact.wrench_cone import LEVEL, line_cone
from drake_linefoot.mpc.condensed_qp import build_qp, constants_of, scaled_cones
from drake_linefoot.mpc.ecd import Linearisation, input_matrices, system_matrices
from drake_linefoot.mpc.parameters import MpcParameters, MpcWeights
from tests.helpers.walking import ground_frame

SCALED = LineContact(1.0).cone(1.0), LineContact.ends


def rollout(problem, wrench, mass):
    """States at the knots, one interval after the other by the matrix exponential."""
    ref, r_G = problem.record.reference, problem.measured.r
    A, C = system_matrices(Linearisation.of(ref), r_G, mass, NO_WRENCH)
    B = input_matrices(ref.p_WC, ref.R_WC, r_G, mass, 5)
    x = problem.qp.x0
    states = [x]
    for k, dt in enumerate(ref.dt):
        rate = np.zeros((13, 13))
        rate[:12, :12], rate[:12, 12] = A[k], B[k] @ wrench[k].ravel() + C[k]
        x = (expm(rate * dt) @ [*x, 1.0])[:12]
        states.append(x)
    return np.array(states)


def cost_of(problem, states, wrench, parameters, mass):
    """The cost (40): an interval counts by its length, in units of the longest."""
    ref, w = problem.record.reference, parameters.weights
    weights = np.array([*w.position, *w.velocity, *w.angular_momentum, *w.orientation])
    inputs = np.array([w.force] * 3 + [w.torque] * 2)
    total = 0.0
    for k, dt in enumerate(ref.dt):
        r, v, L = ref.r[k + 1], ref.v[k + 1], ref.L[k + 1]
        L_fixed = L + mass * np.cross(r - problem.measured.r, v)
        error = states[k + 1] - np.array([*r, *v, *L_fixed, 0.0, 0.0, 0.0])
        effort = sum(float(inputs @ wrench[k, i] ** 2) for i in (0, 1))
        total += dt / parameters.knot_step * (float(weights @ error**2) + effort)
    return total


def random_unknowns(qp, seed):
    rng = np.random.default_rng(seed)
    z = 0.1 * rng.normal(size=len(qp.g))
    z.reshape(-1, 5)[:, 2] += 0.5
    return z


@pytest.fixture(scope="module")
def some(problems):
    return problems[::9]


def test_the_problems_are_of_a_walk(problems):
    sizes = {len(p.qp.g) for p in problems}
    assert len(problems) > 80
    assert {75, 140} <= sizes or min(sizes) < 100 < max(sizes)


def test_predicted_states_are_those_of_a_rollout(humanoid, some):
    """Rows r, r', L_G exactly; eta to the order at which the series is cut, 1e-8."""
    for seed, problem in enumerate(some):
        U = random_unknowns(problem.qp, seed) * problem.qp.scale
        states = rollout(problem, problem.qp.wrenches(U), humanoid.mass)
        np.testing.assert_allclose(
            problem.qp.states(U)[:, :9], states[:, :9], rtol=1e-11, atol=1e-10
        )
        np.testing.assert_allclose(problem.qp.states(U)[:, 9:], states[:, 9:], atol=1e-8)


def test_the_cost_is_the_one_of_a_rollout(humanoid, some):
    parameters = MpcParameters()
    for seed, problem in enumerate(some):
        U = random_unknowns(problem.qp, seed) * problem.qp.scale
        wrench = problem.qp.wrenches(U)
        states = rollout(problem, wrench, humanoid.mass)
        expected = cost_of(problem, states, wrench, parameters, humanoid.mass)
        assert problem.qp.cost(U) == pytest.approx(expected, rel=1e-8)


def test_H_and_g_are_derivatives_of_the_cost(some):
    """A quadratic: central differences are exact but for rounding, whatever the step."""
    for seed, problem in enumerate(some):
        qp = problem.qp
        n = len(qp.g)

        def cost(z, qp=qp):
            return qp.cost(z * qp.scale) / qp.cost_scale

        z = random_unknowns(qp, seed)
        gradient = [(cost(z + e) - cost(z - e)) / 2 for e in np.eye(n)]
        np.testing.assert_allclose(qp.H @ z + qp.g, gradient, rtol=1e-8, atol=1e-7)
        rng = np.random.default_rng(seed)
        for _ in range(5):
            a, b = rng.normal(size=(2, n))
            second = (cost(a + b) - cost(a - b) - cost(b - a) + cost(-a - b)) / 4
            assert a @ qp.H @ b == pytest.approx(second, rel=1e-7, abs=1e-6)
        np.testing.assert_allclose(qp.H, qp.H.T, atol=1e-14)
        assert np.linalg.eigvalsh(qp.H).min() > 0.0


def test_H_and_g_are_those_of_the_paper(some):
    """(47) and (48) with full weight matrices."""
    for problem in some:
        qp = problem.qp
        error = qp.A_qp @ qp.x0 + qp.C_qp - qp.target
        L, K = np.diag(qp.L), np.diag(qp.K)
        unscaled = np.outer(qp.scale, qp.scale) / qp.cost_scale
        H, g = qp.H / unscaled, qp.g * qp.cost_scale / qp.scale
        np.testing.assert_allclose(H, 2.0 * (qp.B_qp.T @ L @ qp.B_qp + K), rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(g, 2.0 * qp.B_qp.T @ L @ error, rtol=1e-9, atol=1e-9)


def test_feet_in_the_air_have_no_unknowns(problems):
    for problem in problems:
        contact, active = problem.record.reference.contact == 1.0, problem.qp.active
        assert len(problem.qp.g) == 5 * np.count_nonzero(contact)
        assert contact[active[:, 0], active[:, 1]].all()
        wrench = problem.qp.wrenches(np.ones(len(problem.qp.g)))
        np.testing.assert_array_equal(wrench[~contact], 0.0)
        np.testing.assert_array_equal(wrench[contact], 1.0)


def test_the_scale_makes_unknowns_of_order_one(humanoid, problems):
    for problem in problems:
        assert 0.1 < np.abs(problem.z).max() < 4.0
        assert 0.2 < np.abs(problem.qp.g).max() < 5.0
    weight = humanoid.mass * 9.81
    units = LineContact(humanoid.half_length).units(humanoid.mass)
    np.testing.assert_allclose(units, weight * np.array([1, 1, 1, 0.075, 0.075]))


# --- cones ------------------------------------------------------------------------------


@given(
    arrays(float, 5, elements=st.floats(-1.0, 1.0)), st.floats(-3.0, 3.0),
    st.floats(0.2, 1.2), st.floats(0.03, 0.15),
)  # fmt: skip
def test_the_scaled_cone_is_the_cone(z, yaw, mu, half_length):
    """Row by row the slack in units of m g, of the wrench turned into the contact frame."""
    R = Rotation.from_euler("z", yaw).as_matrix()
    mass = 24.0
    u = z * LineContact(half_length).units(mass)
    local = np.concatenate([R.T @ u[:3], u[3:]])
    slack = line_cone(mu, half_length) @ local / (mass * 9.81)
    slack[2:] /= half_length
    np.testing.assert_allclose(
        scaled_cones(*SCALED, mu, R[None], LEVEL[None])[0] @ z, slack, atol=1e-12
    )


def test_each_block_has_the_frame_of_its_foot(humanoid, some):
    for problem in some:
        for row, (k, side) in zip(problem.qp.W, problem.qp.active, strict=True):
            ref = problem.record.reference
            R, slope = ref.R_WC[k, side], ref.slope[k, side]
            expected = scaled_cones(*SCALED, 0.6, R[None], slope[None])[0]
            np.testing.assert_allclose(row, expected, atol=1e-15)


# --- solutions --------------------------------------------------------------------------


def test_solutions_of_the_walk_satisfy_the_kkt_conditions(problems):
    """Stationarity with multipliers >= 0 on active rows only; found by non-negative LSQ."""
    for problem in problems:
        qp, z = problem.qp, problem.z
        slack = -np.einsum("nij,nj->ni", qp.W, z.reshape(-1, 5))
        assert slack.min() > -5e-6  # [m g]: 1.2e-3 N
        rows = np.zeros((*qp.W.shape[:2], len(z)))
        for i, W in enumerate(qp.W):
            rows[i, :, 5 * i : 5 * i + 5] = W
        active = rows[slack < 5e-6]
        gradient = qp.H @ z + qp.g
        if len(active):
            _, residual = nnls(active.T, -gradient)
        else:
            residual = np.linalg.norm(gradient)
        assert residual < 1e-5


def test_every_first_wrench_is_within_a_newton_of_the_optimum(problems, accurate):
    """And every later one within five; costs differ by less than 1e-6 of themselves."""
    worst_first, worst = 0.0, 0.0
    for problem in problems:
        qp = problem.qp
        best, U = accurate(qp) * qp.scale, problem.z * qp.scale
        error = np.abs(qp.wrenches(best) - qp.wrenches(U))
        worst_first, worst = max(worst_first, error[0].max()), max(worst, error.max())
        assert qp.cost(U) == pytest.approx(qp.cost(best), rel=1e-6, abs=1e-6)
    assert worst_first < 1.0
    assert worst < 5.0


# --- weights ----------------------------------------------------------------------------


def with_weights(problem, humanoid, **weights):
    weights = replace(MpcWeights(), **weights)
    return with_parameters(problem, humanoid, MpcParameters(weights=weights))


def with_parameters(problem, humanoid, parameters):
    m = problem.measured
    constants = constants_of(parameters, humanoid.mass, humanoid.contact)
    ref = problem.record.reference
    return build_qp(constants, ref, Linearisation.of(ref), problem.qp.x0, m.r)


@pytest.mark.parametrize("name", ["position", "velocity", "angular_momentum", "orientation"])
def test_a_weight_of_zero_leaves_its_states_out(humanoid, problems, name):
    """Moving the target of those states then changes nothing; otherwise it does."""
    at = {"position": 0, "velocity": 3, "angular_momentum": 6, "orientation": 9}[name]
    problem = problems[50]
    for weight, matters in ((0.0, False), (50.0, True)):
        qp = with_weights(problem, humanoid, **{name: [weight] * 3})
        target = qp.target.copy()
        target.reshape(-1, 12)[:, at : at + 3] += 0.3
        moved = replace(qp, target=target)
        U = qp.scale * problem.z
        same = moved.cost(U) == pytest.approx(qp.cost(U), rel=1e-12)
        assert same != matters


@pytest.mark.parametrize(
    ("weights", "column", "reference"),
    [
        ({"position": [0.0, 0.0, 2e5]}, 2, "r"),
        ({"velocity": [1e4, 1e4, 1e4]}, 3, "v"),
        ({"orientation": [3e5, 3e5, 3e5]}, 9, None),
        ({"orientation": [3e5, 3e5, 3e5]}, 10, None),
    ],
)
def test_a_greater_weight_brings_its_state_nearer(
    humanoid, problems, accurate, weights, column, reference
):
    def errors(qp, problem):
        X = qp.states(accurate(qp) * qp.scale)[1:]
        wanted = 0.0
        if reference is not None:
            wanted = getattr(problem.record.reference, reference)[1:, column % 3]
        return np.linalg.norm(X[:, column] - wanted)

    for problem in problems[20::25]:
        greater = errors(with_weights(problem, humanoid, **weights), problem)
        assert greater < 0.7 * errors(problem.qp, problem)


@pytest.mark.parametrize(("name", "part"), [("force", slice(0, 2)), ("torque", slice(3, 5))])
def test_a_greater_weight_makes_its_inputs_smaller(humanoid, problems, accurate, name, part):
    for problem in problems[20::25]:
        sizes = []
        for factor in (1.0, 1e3):
            value = factor * getattr(MpcWeights(), name)
            qp = with_weights(problem, humanoid, **{name: value})
            wrench = qp.wrenches(accurate(qp) * qp.scale)
            sizes.append(np.linalg.norm(wrench[..., part]))
        assert sizes[1] < 0.5 * sizes[0]


def test_friction_bounds_the_horizontal_forces(humanoid, problems, accurate):
    for problem in problems[20::25]:
        for mu in (0.02, 0.6):
            qp = with_parameters(problem, humanoid, MpcParameters(friction=mu))
            wrench = qp.wrenches(accurate(qp) * qp.scale)
            ref = problem.record.reference
            for k, side in qp.active:
                ground = ground_frame(ref.R_WC[k, side], ref.slope[k, side])
                f = ground.T @ wrench[k, side, :3]
                assert np.linalg.norm(f[:2]) <= 1.42 * mu * f[2] + 1e-4
