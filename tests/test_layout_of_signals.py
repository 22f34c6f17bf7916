"""Signals as vectors: what is opened by name in Python and in compiled code is the same number."""

import re
from functools import cache
from itertools import pairwise
from typing import get_type_hints

import numpy as np
import pytest

from drake_linefoot import signals
from drake_linefoot.axes import WRENCH
from drake_linefoot.layout import Layout, Part, filler, flat, opener, parts_of
from drake_linefoot.signals import (
    SIGNALS,
    ContactEstimate,
    GaitTargets,
    SwingTarget,
    WholeBodyReport,
    layouts,
)
from drake_linefoot.statuses import Solved

# A base alone, one joint, the MIT Humanoid, and more than there has been.
ROBOTS = [(6, 0, 1), (7, 1, 2), (24, 18, 14), (31, 25, 40)]
# A contact of a point, of a line and of a surface has 3, 5 and 6 numbers.
SIZES = [
    {"nq": nv + 1, "nv": nv, "na": na, "nw": nw, "knots": knots}
    for (nv, na, knots), nw in zip(ROBOTS, (3, 6, 5, 5), strict=True)
]
MIT = SIZES[2]
SYMBOLS = {"m", "s", "ms", "kg", "N", "rad"}
FRAMES = {"", "W", "B", "W, C", "W, joints"}

every_signal = pytest.mark.parametrize("kind", SIGNALS.values(), ids=SIGNALS)
every_size = pytest.mark.parametrize("sizes", SIZES, ids=str)


def numbered(layout):
    """A vector each of whose numbers says where it is."""
    return np.arange(float(layout.size))


def names_of_sizes(kind):
    """The sizes of which the shapes of a signal are made."""
    axes = [axis for part in parts_of(kind).values() for axis in part.axes]
    return sorted({name for axis in axes if isinstance(axis, str) for name in words(axis)})


def words(text):
    return re.findall("[A-Za-z]+", text)


@cache
def compiled(kind):
    """Opener and filler of a signal, which take the sizes that are named."""
    names = names_of_sizes(kind)
    return opener(kind, *names), filler(kind, *names), names


def sizes_for(kind, sizes):
    return [sizes[name] for name in compiled(kind)[2]]


# --- where the numbers are ------------------------------------------------------------------


@every_signal
@every_size
def test_each_number_has_one_place_in_the_order_of_the_parts(kind, sizes):
    layout = Layout(kind, sizes)
    opened = layout.open(numbered(layout))
    assert type(opened) is kind
    np.testing.assert_array_equal(np.concatenate([np.ravel(p) for p in opened]), numbered(layout))
    places = [layout.place(name) for name in kind._fields]
    assert (places[0].start, places[-1].stop) == (0, layout.size)
    assert all(a.stop == b.start for a, b in pairwise(places))
    for place, part in zip(places, opened, strict=True):
        np.testing.assert_array_equal(numbered(layout)[place], np.ravel(part))


@every_signal
@every_size
def test_parts_have_the_shapes_that_are_declared(kind, sizes):
    layout = Layout(kind, sizes)
    for name, value in layout.open(numbered(layout))._asdict().items():
        part = layout.parts[name]
        assert np.shape(value) == part.shape(sizes) == layout.dtype[name].shape, name
        assert len(part.axes) == np.ndim(value)


def test_vectors_that_are_written_down_by_hand():
    contact, plan = layouts(MIT)["contact"], layouts(MIT)["plan"]
    assert contact.size == 10 + 2 + 24 + 6
    vector = np.zeros(42)
    vector[[7, 11, 12, 41]] = 1.0, 2.0, 3.0, 4.0
    estimate = contact.open(vector)
    assert (estimate.wrench[1, 2], estimate.contact[1]) == (1.0, 2.0)
    assert (estimate.residual[0], estimate.external[5]) == (3.0, 4.0)
    assert contact.name_of(7) == "wrench[1, 2]"
    knots = 15 + 14 * 10 + 2 * 14 * 3 + 15 * 12
    assert plan.size == knots + 3 + 1 + 14 * 2 * 3 + 14 * 2 * 9 + 1 + 15 * 4 + 6 + 5
    assert plan.name_of(knots + 3) == "mass"
    short = layouts(MIT, 3)["plan"]
    assert short.open(np.zeros(short.size)).states.shape == (4, 12)


def test_every_signal_of_a_robot_has_a_layout_with_its_name():
    all_of_them = layouts({name: n for name, n in MIT.items() if name != "knots"}, 5)
    assert list(all_of_them) == list(SIGNALS)
    for name, layout in all_of_them.items():
        assert layout.signal is SIGNALS[name]
        assert layout.size == Layout(SIGNALS[name], MIT | {"knots": 5}).size


@every_signal
@every_size
def test_arrays_are_views_of_the_vector_and_single_numbers_are_floats(kind, sizes):
    layout = Layout(kind, sizes)
    vector = numbered(layout)
    for name, value in layout.open(vector)._asdict().items():
        if not layout.parts[name].axes:
            assert type(value) is float, name
        elif value.size:
            assert np.shares_memory(value, vector), name
            value[...] = -1.0
            assert np.all(vector[layout.place(name)] == -1.0), name
    single = sum(not part.axes for part in layout.parts.values())
    assert np.count_nonzero(vector >= 0.0) == single


@every_signal
@every_size
def test_a_signal_is_the_same_after_it_has_travelled(kind, sizes):
    layout = Layout(kind, sizes)
    vector = np.random.default_rng(1).normal(size=layout.size)
    signal = layout.open(vector)
    for made in (layout.vector(signal), flat(signal)):
        np.testing.assert_array_equal(made, vector)
        assert made.dtype == np.float64
        assert not np.shares_memory(made, vector)


@every_signal
@every_size
def test_every_number_has_a_name_that_finds_it(kind, sizes):
    layout = Layout(kind, sizes)
    opened = layout.open(numbered(layout))
    names = [layout.name_of(i) for i in range(layout.size)]
    assert len(set(names)) == layout.size
    for i, name in enumerate(names):
        part, _, at = name.partition("[")
        index = tuple(map(int, re.findall(r"\d+", at)))
        assert np.asarray(getattr(opened, part))[index] == i
        assert bool(at) == bool(layout.parts[part].axes)
    for outside in (-1, layout.size):
        with pytest.raises(IndexError, match=f"{outside} of {layout.size}"):
            layout.name_of(outside)


# --- compiled -------------------------------------------------------------------------------


@every_signal
def test_compiled_code_opens_a_vector_as_python_does(kind):
    open_compiled = compiled(kind)[0]
    for sizes in SIZES:
        layout = Layout(kind, sizes)
        vector = np.random.default_rng(2).normal(size=layout.size)
        opened, expected = open_compiled(vector, *sizes_for(kind, sizes)), layout.open(vector)
        assert type(opened) is kind
        for name, a, b in zip(kind._fields, opened, expected, strict=True):
            np.testing.assert_array_equal(a, b, err_msg=name)
            assert np.shape(a) == np.shape(b), name
            if np.size(a) and np.ndim(a):
                assert np.shares_memory(a, vector), name


@every_signal
def test_compiled_code_fills_a_vector_as_python_does(kind):
    fill = compiled(kind)[1]
    for sizes in SIZES:
        layout = Layout(kind, sizes)
        expected = np.random.default_rng(3).normal(size=layout.size)
        vector = np.full(layout.size, np.nan)
        fill(vector, layout.open(expected), *sizes_for(kind, sizes))
        np.testing.assert_array_equal(vector, expected)


@pytest.mark.parametrize("name", [n for n in vars(signals) if re.match("(open|fill)_", n)])
def test_the_compiled_functions_of_the_package_are_those_of_their_signals(name):
    """They are given the sizes in the order of their arguments."""
    kind, function = SIGNALS[name.partition("_")[2]], getattr(signals, name)
    arguments = list(function.py_func.__code__.co_varnames[: function.py_func.__code__.co_argcount])
    expected = np.random.default_rng(4).normal(size=Layout(kind, MIT).size)
    signal = Layout(kind, MIT).open(expected)
    if name.startswith("open_"):
        assert arguments[0] == "flat"
        opened = function(expected, *(MIT[a] for a in arguments[1:]))
        np.testing.assert_array_equal(flat(opened), expected)
        assert [np.shape(part) for part in opened] == [np.shape(part) for part in signal]
    else:
        assert arguments[:2] == ["flat", "signal"]
        vector = np.full(len(expected), np.nan)
        function(vector, signal, *(MIT[a] for a in arguments[2:]))
        np.testing.assert_array_equal(vector, expected)


# --- what does not fit ----------------------------------------------------------------------


@every_signal
def test_a_part_of_another_shape_is_refused(kind):
    layout = Layout(kind, MIT)
    good = layout.open(numbered(layout))
    for name, value in good._asdict().items():
        wrong = [np.zeros((2, *np.shape(value)))]
        if np.ndim(value):
            wrong += [value[:-1], value[..., None], 0.0]
        for bad in wrong:
            with pytest.raises(ValueError, match="must have"):
                layout.vector(good._replace(**{name: bad}))


@every_signal
def test_a_vector_that_is_too_short_or_has_gaps_cannot_be_opened(kind):
    layout = Layout(kind, MIT)
    with pytest.raises(TypeError, match="too small"):
        layout.open(np.zeros(layout.size - 1))
    with pytest.raises(ValueError, match="contiguous"):
        layout.open(np.zeros(2 * layout.size)[::2])


def test_a_size_that_is_not_said_is_missed():
    with pytest.raises(NameError, match="nw"):
        Layout(ContactEstimate, {"knots": 14})
    assert Layout(GaitTargets, {}).size == Layout(GaitTargets, MIT).size


# --- what is said of the parts --------------------------------------------------------------


@pytest.mark.parametrize("kind", [*SIGNALS.values(), SwingTarget], ids=[*SIGNALS, "swing"])
def test_every_part_says_what_it_is_and_in_which_unit(kind):
    assert kind.__doc__
    types = get_type_hints(kind)
    for name, part in parts_of(kind).items():
        assert part.meaning, name
        assert part.frame in FRAMES, name
        for unit in re.split(", ", part.unit):
            assert unit == "-" or set(words(unit)) <= SYMBOLS, (name, unit)
            assert unit, name
        assert (types[name] is float) == (part.axes == ()), name


@every_signal
@every_size
def test_every_entry_of_an_axis_has_a_name_and_every_number_a_unit(kind, sizes):
    named = {name: tuple(f"{name}_{i}" for i in range(n)) for name, n in sizes.items()}
    for name, part in parts_of(kind).items():
        entries = part.names(named)
        assert tuple(map(len, entries)) == part.shape(sizes), name
        assert all(len(set(axis)) == len(axis) for axis in entries), name
        if len(part.units) > 1:
            units = part.entry_units(part.shape(sizes)[-1])
            assert len(units) == part.shape(sizes)[-1], name
            first = (
                sum(part.groups[: len(part.units) - 1]) or len(part.units) - 1
            )  # a point's wrench has no torque
            units_there = part.units if len(units) > first else part.units[:-1]
            assert set(units) == set(units_there), name


def test_units_belong_to_groups_of_entries_and_the_last_takes_the_rest():
    each = Part("", ("m", "rad"), ("x", "yaw"))
    groups = Part("", ("-", "m", "rad"), "nq", groups=(4, 3))
    assert each.entry_units(2) == ["m", "rad"]
    assert groups.entry_units(9) == ["-"] * 4 + ["m"] * 3 + ["rad"] * 2
    assert Part("", "N").entry_units(3) == ["N"] * 3
    wrench = parts_of(ContactEstimate)["wrench"]
    assert wrench.entry_units(5) == ["N", "N", "N", "N m", "N m"]
    assert dict(zip(WRENCH, wrench.entry_units(6), strict=True))["tau_y"] == "N m"


def test_names_of_entries_are_those_of_the_robot_where_it_has_some():
    part = Part("", "rad", ("left", "right"), "na", "na + 1", 2)
    left_right, joints, one_more, two = part.names({"na": ("hip", "knee")})
    assert (left_right, joints) == (("left", "right"), ("hip", "knee"))
    assert (one_more, two) == (("0", "1", "2"), ("0", "1"))


def test_the_rows_of_a_swing_are_those_of_its_target():
    targets = Layout(GaitTargets, {})
    opened = targets.open(numbered(targets))
    for side in (0, 1):
        for row, name in zip(opened.swing[side], SwingTarget._fields, strict=True):
            np.testing.assert_array_equal(getattr(opened.swing_target(side), name), row)
    assert parts_of(GaitTargets)["swing"].axes[1] == SwingTarget._fields


def test_a_status_says_whether_there_is_a_solution_and_why_not():
    good = {Solved.GIVEN, Solved.NO_CONTACT, Solved.UNCONSTRAINED, Solved.ACTIVE_SET, Solved.SOLVER}
    assert {status for status in Solved if status.success} == good
    assert Solved.ITERATION_LIMIT.words == "iteration limit"
    report = Layout(WholeBodyReport, MIT).open(np.zeros(Layout(WholeBodyReport, MIT).size))
    assert report._replace(status=float(Solved.SOLVER)).success
    assert not report._replace(status=float(Solved.FAILED)).success


def test_compiled_functions_of_signals_are_told_apart_by_name():
    """Numba counts functions in each process, so that only names differ where code comes together.

    With one name for all, a horizon compiled by one process was opened as the reference that
    another process had compiled.
    """
    made = [one for kind in SIGNALS.values() for one in compiled(kind)[:2]]
    names = {(one.py_func.__module__, one.py_func.__qualname__) for one in made}
    assert len(names) == len(made)
    assert {module for module, _ in names} == {"drake_linefoot.signals"}
