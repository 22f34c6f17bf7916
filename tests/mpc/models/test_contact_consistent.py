"""How the torso turns over feet that move as planned, against the full plant."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.gait.schedule import feet_motion
from drake_linefoot.mpc.ecd import centroidal_state, system_matrices
from drake_linefoot.mpc.models.contact_consistent import (
    DAMPING,
    NEAR_SINGULAR,
    angular_momentum,
    contact_maps,
    damped_inverse,
    moving_legs,
    torso_rates,
)
from drake_linefoot.mpc.models.ecd import ECD
from drake_linefoot.mpc.models.motion import (
    body_motion,
    line_plan,
    places_in_torso,
    rates_in_torso,
)
from drake_linefoot.mpc.models.reaching import determinant
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.leg_inertia import LegInertia
from drake_linefoot.robot.leg_kinematics import forward, inverse
from drake_linefoot.robot.legs import read_legs
from tests.helpers.walking import (
    dynamics_of,
    mirror_horizon,
    mirror_reference,
    recorded_walk,
    robot,
)


class Case:
    """A robot and configurations of a walk, shape (n, nq)."""

    def __init__(self, humanoid, q):
        self.robot, self.q, self.legs = humanoid, q, read_legs(humanoid)
        self.nominal = determinant(self.legs, humanoid.q_nominal[humanoid.leg_q])

    def dynamics(self, q, v):
        return robot_dynamics(self.robot, self.robot.scratch, np.concatenate([q, v]))

    def moving(self, rng):
        """The configurations with some velocities; arms at rest."""
        for q in self.q:
            v = rng.normal(size=self.robot.nv)
            v[self.robot.arm_v] = 0.0
            yield self.dynamics(q, v)

    def maps_of(self, d, feet):
        """A_c and c of a state, whose feet move as they are said to."""
        h, R_BW = self.robot, d.R_WB.T
        v, w = (np.ascontiguousarray((x @ R_BW.T)[:, None]) for x in (feet.v_WC, feet.w_WF))
        angles = np.ascontiguousarray(d.q[h.leg_q][:, None])
        maps = LegInertia(h, self.legs)(d, angles)
        return contact_maps(self.legs, angles, maps, v, w, h.mass, self.nominal)

    def torso_rate(self, d, A, c):
        """Angular velocity of the torso in B by the model, given the momenta of a state."""
        R_BW = d.R_WB.T
        momenta = np.concatenate([R_BW @ d.L_G, self.robot.mass * R_BW @ d.v_WG])
        return torso_rates(A)[0] @ (momenta - c[0])


@pytest.fixture(scope="module", params=["line", "surface"])
def case(request, walking_state):
    if request.param == "line":
        return Case(robot(), [record.x[: robot().nq] for record in recorded_walk().wbc[60::60]])
    soled = request.getfixturevalue("sole_biped")
    return Case(soled, [walking_state(soled, seed)[: soled.nq] for seed in range(6)])


def test_the_torso_turns_as_the_plants_does(case):
    """Whatever both feet do, standing or swinging: w of the momenta and of the feet is w."""
    for d in case.moving(np.random.default_rng(3)):
        A, c = case.maps_of(d, d)
        np.testing.assert_allclose(case.torso_rate(d, A, c), d.R_WB.T @ d.v[:3], atol=1e-9)


@pytest.mark.parametrize("standing", [(0, 1), (0,), (1,)])
def test_feet_that_are_said_to_stand_take_the_legs_with_them(case, standing):
    """The plant's rates with feet held, by least squares over all its velocities."""
    h = case.robot
    for moving in case.moving(np.random.default_rng(4)):
        held = np.vstack([*moving.J[list(standing)], np.eye(h.nv)[h.arm_v]])
        v = moving.v - np.linalg.pinv(held) @ held @ moving.v
        d = case.dynamics(moving.q, v)
        A, c = case.maps_of(d, d)
        if len(standing) == 2:
            np.testing.assert_allclose(c, 0.0, atol=1e-8)
        np.testing.assert_allclose(case.torso_rate(d, A, c), d.R_WB.T @ v[:3], atol=1e-9)


def test_the_angular_momentum_goes_with_the_torsos_rate(case):
    for d in case.moving(np.random.default_rng(5)):
        A, c = case.maps_of(d, d)
        R_BW = d.R_WB.T
        p = case.robot.mass * R_BW @ d.v_WG
        L = angular_momentum(A, c, (R_BW @ d.v[:3])[None], p[None])
        np.testing.assert_allclose(L[0], R_BW @ d.L_G, atol=1e-9)


def test_a_torso_over_standing_feet_is_lighter_than_with_locked_joints(case):
    """What it feels about x and y is what it has to take along: less of the legs."""
    d = case.dynamics(case.robot.q_nominal, np.zeros(case.robot.nv))
    A, _ = case.maps_of(d, d)
    felt = np.diag(np.linalg.inv(torso_rates(A)[0][:, :3]))
    locked = np.diag(d.R_WB.T @ d.A[:3, :3] @ d.R_WB)
    assert (felt > 0.0).all()
    assert (felt[:2] < 0.75 * locked[:2]).all()


@pytest.mark.parametrize("bend", [0.0, 1e-4, 1e-2, 0.05])
def test_a_straight_knee_gives_bounded_rates(case, bend):
    """The damped inverse of Nakamura and Hanafusa: its norm is at most 1 / (2 root of damping)."""
    legs, nominal, n = case.legs, case.nominal, case.robot.contact.size
    angles = case.robot.q_nominal[case.robot.leg_q][:, None].copy()
    knee = 3
    angles[:, :, knee] = bend
    _, R, J = forward(legs, angles)
    E = np.vstack([J[0, 0, :3], R[0, 0].T[[1, 2, 0][: n - 3]] @ J[0, 0, 3:]])
    share = abs(np.linalg.det(E)) / (NEAR_SINGULAR * nominal)
    inverse = damped_inverse((0.0,) * len(E), np.ascontiguousarray(E), nominal)
    if share >= 1.0:
        np.testing.assert_allclose(inverse @ E, np.eye(n), atol=1e-9)
    else:
        damping = DAMPING * nominal ** (2.0 / n) * (1.0 - share**2)
        assert np.linalg.norm(inverse, 2) <= 0.5 / np.sqrt(damping) * (1.0 + 1e-6)
        expected = E.T @ np.linalg.inv(E @ E.T + damping * np.eye(n))
        np.testing.assert_allclose(inverse, expected, atol=1e-6)


def test_the_first_interval_is_not_longer_than_a_plan_is_used():
    """With the ECD all are up to 40 ms long; as many intervals in both."""
    locked, period = ReferenceGenerator(robot(), MpcParameters(model="ecd")), MpcParameters().period
    for ref, d, horizon in references():
        ecd = locked.generate(horizon, d)
        assert ref.dt[0] <= period + 1e-8
        assert ref.dt[1:].max() > period
        assert len(ref.dt) == len(ecd.dt)
        assert ref.E.shape == (len(ref.I_B), 3, 6)
        assert (len(moving_legs(ref).E), len(ECD.linearise(ecd).E)) == (len(ref.dt), 0)
        assert ref.E.any(axis=(1, 2)).all()
        assert ecd.E.shape == ref.E.shape
        assert not ecd.E.any()
        assert ref.times[0] == ecd.times[0]


def references(step=40):
    """References of a walk with the present dynamics and the horizon they are made of."""
    generator = ReferenceGenerator(robot(), MpcParameters(model="contact_consistent"))
    for record in recorded_walk().mpc[10::step]:
        d = dynamics_of(record.x)
        yield generator.generate(record.horizon, d), d, record.horizon


def test_the_model_is_the_derivative_of_the_torsos_rate():
    """Rows of eta: w - w_d of the momenta in the axes of R_d, by central differences."""
    m, r_G, h = robot().mass, np.array([0.3, -0.4, 0.5]), 1e-4
    for ref, _, _ in references(80):
        A, C = system_matrices(moving_legs(ref), r_G, m, NO_WRENCH)
        for k in (0, 5, -1):
            E, R, L_d, v_d = ref.E[k], ref.R_mid[k], ref.L_mid[k], ref.v_mid[k]

            def rate(state, E=E, R=R, L_d=L_d, v_d=v_d):
                r, v, L_G = state[:3], state[3:6], state[6:9]
                L = L_G - m * np.cross(r - r_G, v)
                return E[:, :3] @ R.T @ (L - L_d) + E[:, 3:] @ R.T @ (m * (v - v_d))

            x = centroidal_state(ref.r_mid[k], v_d, L_d, np.zeros(3), r_G, m)
            np.testing.assert_allclose(rate(x), 0.0, atol=1e-12)
            np.testing.assert_allclose(A[k, 9:] @ x + C[k, 9:], 0.0, atol=1e-10)
            numeric = [(rate(x + h * e) - rate(x - h * e)) / (2.0 * h) for e in np.eye(12)]
            np.testing.assert_allclose(A[k, 9:], np.transpose(numeric), atol=1e-7)


def test_what_a_tilt_changes_of_the_rate_is_small():
    """Left out: d w / d eta with CoM, momenta and feet held is below 1 /s, most often 0.3 /s.

    Over the 20 ms in which a plan is used that is a hundredth of the tilt itself.
    """
    h, step = robot(), 1e-3
    g = ReferenceGenerator(h, MpcParameters(model="contact_consistent"))

    def turned(body, lines, d, momenta):
        offset = d.R_WB.T @ (d.p_WG - d.q[4:7])
        p, R = places_in_torso(body, lines)
        guess = np.repeat(d.q[h.leg_q][:, None], len(body.r), axis=1)
        angles, _ = inverse(g._robot.legs, p + offset, R, guess, 12, 1e-9)
        maps = g._inertia(d, angles)
        moving = rates_in_torso(body, lines)
        A, c = contact_maps(g._robot.legs, angles, maps, *moving, h.mass, g._robot.determinant)
        in_B = (np.swapaxes(body.R, 1, 2)[:, None] @ momenta[..., None])[..., 0].reshape(-1, 6)
        return (body.R @ torso_rates(A) @ (in_B - c)[..., None])[..., 0]

    slopes = []
    for ref, d, horizon in references(60):
        middle = 0.5 * (ref.times[1:] + ref.times[:-1])
        body = body_motion(horizon, d.p_WG, middle)
        lines = line_plan(feet_motion(horizon, middle), ref.slope, 5)
        momenta = np.stack([ref.L_mid, h.mass * ref.v_mid], axis=1)
        for axis in np.eye(3):
            ahead, back = (
                turned(body._replace(R=tilted), lines, d, momenta)
                for tilted in (
                    np.ascontiguousarray(body.R @ Rotation.from_rotvec(s * axis).as_matrix())
                    for s in (step, -step)
                )
            )
            slopes.append((ahead - back) / (2.0 * step))
    assert 0.05 < np.sqrt(np.mean(np.square(slopes))) < 0.3
    assert np.abs(slopes).max() < 1.0


def shifted_rates(d, step=1e-5):
    """d w / d r of the plant, in W [rad/(m s)], with orientation, momenta and feet held.

    All velocities follow from both momenta, the rates of both lines and those of the arms; the
    joint angles from a CoM that moves while torso, lines and arms do not.
    """
    h = robot()
    rest = np.vstack([*d.J, np.eye(h.nv)[h.arm_v]])
    held = np.vstack([np.eye(h.nv)[:3], d.A[3:] / h.mass, rest])
    known, context = np.concatenate([d.A @ d.v, rest @ d.v]), h.plant.CreateDefaultContext()
    h.plant.SetPositions(context, d.q)
    columns = []
    for i in range(3):
        way = h.plant.MapVelocityToQDot(context, np.linalg.solve(held, np.eye(h.nv)[3 + i]))
        ahead, back = (dynamics_of(np.concatenate([d.q + s * way, d.v])) for s in (step, -step))
        w = [
            np.linalg.solve(np.vstack([e.A, *e.J, np.eye(h.nv)[h.arm_v]]), known)[:3]
            for e in (ahead, back)
        ]
        columns.append((w[0] - w[1]) / (2.0 * step))
    return np.transpose(columns)


def test_what_a_shift_of_the_com_changes_of_the_rate_is_small_along_a_plan():
    """Left out: d w / d r with L, m r' and feet held, a seventh of the whole at 0.5 m/s.

    Whole is what the model has of it, by L at a given L_G, and this. Along a plan, whose CoM is
    some millimetres from the reference, it makes a milliradian of tilt.
    """
    m, records = robot().mass, recorded_walk().mpc[2:]
    g = ReferenceGenerator(robot(), MpcParameters(model="contact_consistent"))
    begins, left_out, shares, tilts = [], [], [], []
    for record in records:
        d = dynamics_of(record.x)
        ref = g.generate(record.horizon, d)
        A, _ = system_matrices(moving_legs(ref), ref.r_mid[0], m, NO_WRENCH)
        begins.append(ref.times[0])
        left_out.append(shifted_rates(d))
        whole = ref.R_mid[0] @ A[0, 9:, :3] + left_out[-1]
        if begins[-1] > 1.2:  # it has its speed
            shares.append(np.linalg.norm(left_out[-1]) / np.linalg.norm(whole))
    assert 0.1 < np.median(shares) < 0.2
    begins, left_out = np.array(begins), np.array(left_out)
    for record in records:
        ref, off = record.reference, record.plan.states[:, :3] - record.reference.r
        if ref.times[-1] < begins[-1]:
            middle, off = 0.5 * (ref.times[1:] + ref.times[:-1]), 0.5 * (off[1:] + off[:-1])
            then = left_out[np.abs(begins[:, None] - middle).argmin(axis=0)]
            tilt = np.cumsum(np.matvec(then, off) * ref.dt[:, None], axis=0)
            tilts.append(np.linalg.norm(tilt[:, :2], axis=1).max())
    assert len(tilts) > 50
    assert 1e-4 < np.median(tilts) < 6e-4
    assert max(tilts) < 2e-3


def test_left_and_right_turn_alike():
    """E of the mirrored robot is E mirrored."""
    generator = ReferenceGenerator(robot(), MpcParameters(model="contact_consistent"))
    for record in recorded_walk().mpc[10::60]:
        d = dynamics_of(record.x)
        ref = mirror_reference(generator.generate(record.horizon, d))
        other = generator.generate(
            mirror_horizon(record.horizon), dynamics_of(robot().mirror_state(record.x))
        )
        np.testing.assert_allclose(other.E, ref.E, atol=1e-6)
        np.testing.assert_allclose(other.L, ref.L, atol=1e-6)
