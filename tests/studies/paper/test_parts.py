"""The ECD with parts taken away: each variant changes one thing, and the figure says which."""

import numpy as np
import pytest

from drake_linefoot.lab.scenario.load import dump_scenario
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.robot.dynamics import robot_dynamics
from studies.common.runs import paper_scenario
from studies.common.trial import walk
from studies.paper import parts
from tests.helpers.walking import recorded_walk, robot


@pytest.fixture(scope="module")
def references():
    """The reference of each variant, for one moment of a walk with a foot in the air."""
    record = next(r for r in recorded_walk().mpc if r.horizon.coming > 1)
    d = robot_dynamics(robot(), robot().plant.CreateDefaultContext(), record.x)
    return {
        name: kind(robot(), MpcParameters(model=model)).generate(record.horizon, d)
        for name, (model, kind) in parts.VARIANTS.items()
    }


def test_each_variant_takes_away_one_thing(references):
    ecd, rigid = references["ECD"], references["single rigid body"]
    momentum = references["without the legs' momentum"]
    np.testing.assert_array_equal(momentum.I_B, ecd.I_B)
    locked = (ecd.R_mid @ ecd.I_B @ ecd.Omega_mid[..., None])[..., 0]
    np.testing.assert_allclose(momentum.L_mid, locked, rtol=0, atol=1e-12)
    assert np.abs(ecd.L_mid - locked).max() > 0.1  # the legs do move
    frozen = references["with a frozen inertia"]
    np.testing.assert_array_equal(frozen.L_mid, ecd.L_mid)
    np.testing.assert_array_equal(frozen.I_B, rigid.I_B)
    assert np.ptp(frozen.I_B, axis=0).max() == 0.0 < np.ptp(ecd.I_B, axis=0).max()
    even = references["knots in even steps"]
    np.testing.assert_allclose(even.dt, MpcParameters().knot_step, rtol=0, atol=1e-12)
    assert np.ptp(ecd.dt) > 1e-3


def test_the_variant_is_what_walks():
    text = dump_scenario(walk(paper_scenario(quick=False), (0.3, 0.0, 0.0), 1.0))
    for variant, (model, kind) in parts.VARIANTS.items():
        loop = parts.build(variant, text)
        assert loop.scenario.mpc.model == model
        generator = loop.controller.GetSubsystemByName("centroidal_reference")._generator
        assert type(generator) is kind
    assert parts.VARIANTS["ECD"][1] is ReferenceGenerator


def row(variant, command, roll, pitch, fell=False):
    return {
        "variant": variant,
        "command": command,
        "roll_rms": roll,
        "pitch_rms": pitch,
        "speed_error": None if fell else 0.01,
        "fell": fell,
        "fall_time": 1.5 if fell else None,
    }


def test_claims_table_and_picture():
    names = list(parts.VARIANTS)
    rows = [row(name, "a", 0.003 * (i + 1), 0.01 * (4 - i)) for i, name in enumerate(names)]
    rows += [row(name, "b", 0.003, 0.01, fell=name == names[2]) for name in names]
    data = {"rows": rows, "duration": 6.0}
    momentum, inertia, held = parts.claims(data)
    assert "roll 0.33, pitch 2.00" in momentum.ours  # where both stand: command a alone
    assert not momentum.holds
    expected = np.sqrt((0.003**2 + 0.003**2) / (0.012**2 + 0.003**2))
    assert f"roll {expected:.2f}" in inertia.ours
    assert held.claim == "The robot tilts more with the horizontal CoM held"
    table = parts.table(data)
    assert len(table) == 1 + 2 * len(names)
    assert {len(line) for line in table} == {6}
    assert sum("at 1.50 s" in line for line in table) == 1
    figure = parts.draw(data)
    assert len(figure.axes) == 4
    labels = [label.get_text() for label in figure.axes[2].get_yticklabels()]
    assert "without the legs' momentum (FELL)" in labels
