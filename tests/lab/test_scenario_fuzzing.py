"""Scenarios at random: whatever a file holds, it loads or is refused with one line."""

import copy

import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_linefoot.errors import ScenarioError
from drake_linefoot.lab.scenario.load import dump_scenario, load_scenario, parse_scenario, validate

VALID = yaml.safe_load(dump_scenario(load_scenario("walk")))
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(min_value=10**300, max_value=10**320),
    st.floats(),
    st.floats(min_value=0.0, max_value=2.0),
    st.text(max_size=8),
    st.sampled_from(["ecd", "srbm", "left", "clarabel", "1e-3", ".nan", "x.yaml", "a/b.yaml"]),
    st.dates(),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=6,
)


def places(data, at=()):
    """Return the path of every entry in nested mappings and lists."""
    entries = data.items() if isinstance(data, dict) else enumerate(data)
    found = []
    for key, value in list(entries):
        found.append((*at, key))
        if isinstance(value, dict | list):
            found.extend(places(value, (*at, key)))
    return found


@st.composite
def mutated(draw):
    """A valid scenario with a few entries replaced, dropped or added."""
    data = copy.deepcopy(VALID)
    for _ in range(draw(st.integers(1, 3))):
        *parents, last = draw(st.sampled_from(places(data) or [("gait",)]))
        target = data
        for key in parents:
            target = target[key]
        action = draw(st.sampled_from(["replace", "drop", "add"]))
        if action == "drop":
            del target[last]
        elif action == "add" and isinstance(target, dict):
            target[draw(st.text(max_size=6))] = draw(VALUES)
        else:
            target[last] = draw(VALUES)
    return data


def loads_or_refuses(text):
    try:
        scenario = parse_scenario(text, "a.yaml")
        validate(scenario, "a.yaml")
    except ScenarioError as error:
        assert len(str(error).splitlines()) == 1
        assert len(str(error)) < 1000
        assert str(error).startswith("a.yaml")
    else:
        assert parse_scenario(dump_scenario(scenario)) == scenario


@settings(max_examples=200)
@given(data=mutated())
def test_mutated_scenarios_load_or_are_refused(data):
    loads_or_refuses(yaml.safe_dump(data, allow_unicode=True))


@settings(max_examples=200)
@given(text=st.text(max_size=40) | st.text("[]{}:,-&*!|>'\"#%@ \n\t0.e~a", max_size=40))
def test_any_text_loads_or_is_refused(text):
    loads_or_refuses(text)
