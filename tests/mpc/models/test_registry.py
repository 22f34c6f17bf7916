"""Models of the MPC by their names: those that are shipped, and one's own."""

import ast
import runpy
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import drake_linefoot
from drake_linefoot.errors import InputError, ScenarioError
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.load import load_scenario, parse_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.mpc.ecd_mpc import EcdMpc
from drake_linefoot.mpc.models.contact_consistent import CONTACT_CONSISTENT, moving_legs
from drake_linefoot.mpc.models.ecd import ECD
from drake_linefoot.mpc.models.registry import MODELS, model_named, register
from drake_linefoot.mpc.models.single_body import SINGLE_BODY, SINGLE_BODY_MOMENTUM
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.mpc.solve import MpcSolver
from tests.helpers.full_plant import composite_inertia
from tests.helpers.walking import dynamics_of, recorded_walk, robot

PACKAGE = Path(drake_linefoot.__file__).parent
EXAMPLE = PACKAGE.parent / "examples" / "09_own_model.py"
SHIPPED = ["ecd", "contact_consistent", "srbm", "srbm_momentum"]


@pytest.fixture
def frozen(own_models):
    """The example's model, registered."""
    model = runpy.run_path(str(EXAMPLE))["FROZEN"]
    own_models(model)
    return model


def reference(model, record):
    generator = ReferenceGenerator(robot(), MpcParameters(model=model))
    return generator.generate(record.horizon, dynamics_of(record.x))


# --- names ------------------------------------------------------------------------------


def test_the_shipped_ones_are_known_by_their_names():
    assert list(MODELS) == SHIPPED
    every = (ECD, CONTACT_CONSISTENT, SINGLE_BODY, SINGLE_BODY_MOMENTUM)
    assert [model_named(name) for name in SHIPPED] == list(every)
    assert len({model.title for model in every}) == 4


def test_a_name_is_taken_once(own_models):
    for taken in SHIPPED:
        with pytest.raises(InputError, match=f"'{taken}': is taken"):
            register(replace(ECD, name=taken))
    assert MODELS["ecd"] is ECD
    mine = replace(ECD, name="mine")
    own_models(mine)
    with pytest.raises(InputError, match=r"is taken; must not be one of .*'srbm', .*'mine'"):
        register(replace(mine, title="another"))
    assert MODELS["mine"] is mine


def test_an_unknown_name_is_refused_with_those_that_are_known(own_models):
    known = "'ecd', 'contact_consistent', 'srbm', 'srbm_momentum'"
    for make in (
        lambda: ReferenceGenerator(robot(), MpcParameters(model="lip")),
        lambda: EcdMpc(robot(), MpcParameters(model="lip")),
        lambda: MpcSolver(MpcParameters(model="lip"), 20.0, robot().contact),
        lambda: parse_scenario("mpc: {model: lip}"),
        lambda: load_scenario("walk", {"mpc.model": "lip"}),
    ):
        with pytest.raises(InputError, match=rf"mpc.model = 'lip': must be one of \[{known}\]"):
            make()
    own_models(replace(ECD, name="mine"))
    with pytest.raises(InputError, match=rf"must be one of \[{known}, 'mine'\]"):
        model_named("lip")
    with pytest.raises(ScenarioError, match=rf"must be one of \[{known}, 'mine'\]"):
        parse_scenario("mpc: {model: lip}")


def test_no_other_file_of_the_package_knows_a_name():
    """As text of its own: the registry does, and the parameters have the name of the default."""
    found = {}
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and node.value in SHIPPED:
                found.setdefault(node.value, set()).add(path.relative_to(PACKAGE).as_posix())
    registry = "mpc/models/registry.py"
    assert found == {
        "ecd": {"mpc/models/ecd.py", registry},
        "contact_consistent": {"mpc/models/contact_consistent.py", registry, "mpc/parameters.py"},
        "srbm": {"mpc/models/single_body.py", registry},
        "srbm_momentum": {"mpc/models/single_body.py", registry},
    }


def test_a_scenario_is_checked_without_loading_a_model():
    """Numba and all that a model needs take most of a second."""
    code = (
        "import sys; from drake_linefoot.lab.scenario.load import make_scenario; "
        "make_scenario({'mpc': {'model': 'ecd'}}); sys.exit('numba' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], timeout=60, check=True)


# --- a model of one's own ---------------------------------------------------------------


def test_a_registered_model_walks_from_a_scenario_and_from_python(frozen):
    text = "segments: [{name: a, duration: 0.3, walk: true}]\nmpc: {model: frozen_inertia}"
    segments = [Segment("a", 0.3, walk=True)]
    ecd, mine = (
        simulate(build_closed_loop(Scenario(segments=segments, mpc=MpcParameters(model=name))))
        for name in ("ecd", frozen.name)
    )
    same = simulate(build_closed_loop(parse_scenario(text)))
    np.testing.assert_array_equal(same.q, mine.q)
    assert same.scenario.mpc.model == "frozen_inertia"
    assert not mine.fell
    assert np.abs(mine.q - ecd.q).max() > 1e-7


def test_each_term_of_a_model_counts(own_models):
    """All that a loop computes with a model is what its functions give."""
    called = []

    def spied(name):
        given = getattr(ECD, name)

        def call(*arguments):
            called.append(name)
            return given(*arguments)

        return call

    terms = ("write_reference", "knots", "measure", "linearise")
    own_models(replace(ECD, name="spied", **{name: spied(name) for name in terms}))
    segments = [Segment("a", 0.1, walk=True)]
    mine, ecd = (
        simulate(build_closed_loop(Scenario(segments=segments, mpc=MpcParameters(model=name))))
        for name in ("spied", "ecd")
    )
    assert {name: called.count(name) for name in terms} == dict.fromkeys(terms, 5)
    np.testing.assert_array_equal(mine.q, ecd.q)


def test_knots_are_those_of_the_model_and_as_many_as_were_asked_for(own_models):
    record = recorded_walk().mpc[40]

    def even(horizon, begin, count, step, period):
        return begin + step * np.arange(count + 1.0)

    def one_more(horizon, begin, count, step, period):
        return even(horizon, begin, count + 1, step, period)

    own_models(replace(ECD, name="even", knots=even))
    own_models(replace(ECD, name="one more", knots=one_more))
    ref = reference("even", record)
    np.testing.assert_allclose(ref.dt, np.full(14, 0.04), rtol=0, atol=1e-12)
    assert ref.times[0] == record.horizon.time
    with pytest.raises(InputError, match=r"model one more: knots = \(16,\): must be 15 knots"):
        reference("one more", record)


def test_a_model_that_takes_the_rate_from_a_reference_needs_it_there():
    record = recorded_walk().mpc[40]
    own = moving_legs(reference("contact_consistent", record))
    assert own.E.shape == (14, 3, 6) and own.E.any()
    with pytest.raises(InputError, match=r"reference: E = 0.0: .* contact_consistent"):
        moving_legs(record.reference)


# --- the example ------------------------------------------------------------------------


def test_the_examples_model_freezes_the_inertia_and_keeps_the_momentum(frozen):
    """Against the plant's own inertia about the CoM, at moments with a foot in the air."""
    context = robot().plant.CreateDefaultContext()
    records = [r for r in recorded_walk().mpc if r.reference.contact[0].min() == 0.0][::10]
    assert len(records) > 3
    for record in records:
        expected = composite_inertia(robot(), context, dynamics_of(record.x).q)
        ecd, mine = (reference(name, record) for name in ("ecd", frozen.name))
        np.testing.assert_allclose(mine.I_B, np.tile(expected, (14, 1, 1)), rtol=0, atol=1e-9)
        assert np.abs(ecd.I_B - expected).max() > 1e-3
        for name in ("L", "L_mid", "times", "r", "R", "reach_error"):
            np.testing.assert_array_equal(getattr(mine, name), getattr(ecd, name))


def test_the_examples_model_plans_other_wrenches(frozen):
    record = recorded_walk().mpc[60]
    plans = []
    for name in ("ecd", frozen.name):
        parameters = MpcParameters(model=name, solver="clarabel", tolerance=1e-10)
        solver = MpcSolver(parameters, robot().mass, robot().contact)
        plans.append(solver.solve(reference(name, record), ECD.measure(dynamics_of(record.x))))
    ecd, mine = plans
    assert ecd.success and mine.success
    assert np.abs(ecd.wrench - mine.wrench).max() > 0.1
