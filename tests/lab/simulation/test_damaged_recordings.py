"""Recordings that are damaged, cut, forged or of other shapes: one error each, of one line."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_linefoot.errors import InputError
from drake_linefoot.lab.simulation import log as log_module
from drake_linefoot.lab.simulation.log import LogFile
from drake_linefoot.lab.simulation.recording import CHANNELS, LOG, WALL_TIMES, Run
from tests.helpers.recorded_runs import make_run

TIME = np.arange(11) * 1e-3


def refusal(file):
    """Return the message with which a recording is refused, "" when it is not.

    What is damaged of a channel is said when it is used.
    """
    try:
        run = Run.load(file)
        for name in CHANNELS:
            getattr(run, name)
    except InputError as error:
        message = str(error)
        assert message.startswith(str(file))
        assert "\n" not in message
        assert len(message) < len(str(file)) + 300
        return message
    return ""


@settings(max_examples=200, deadline=None)
@given(
    flips=st.lists(st.tuples(st.integers(0, 2**20), st.integers(0, 7)), max_size=4),
    cut=st.none() | st.floats(0.0, 1.0),
)
def test_flipped_and_cut_recordings_are_read_right_or_refused(tmp_path_factory, whole, flips, cut):
    changed = bytearray(whole.read_bytes())
    for at, bit in flips:
        changed[at % len(changed)] ^= 1 << bit
    if cut is not None:
        del changed[int(cut * len(changed)) :]
    file = tmp_path_factory.getbasetemp() / LOG
    file.unlink(missing_ok=True)
    file.write_bytes(changed)
    if not refusal(file):
        again, before = Run.load(file), make_run(TIME)
        n = len(again.time)
        assert n in (0, len(TIME))  # they are one batch
        for name in CHANNELS:
            np.testing.assert_array_equal(getattr(again, name), getattr(before, name)[:n])


def written(file, change=lambda arrays, begin, end: None):
    """Write a log of changed arrays, begin and end."""
    run = make_run(TIME)
    begin, end = run.facts()
    arrays = {name: getattr(run, name) for name in CHANNELS}
    change(arrays, begin, end)
    dtype = np.dtype([(name, "f8", values.shape[1:]) for name, values in arrays.items()])
    count = max(map(len, arrays.values()))
    log, rows = LogFile(file, dtype, CHANNELS, begin), np.empty(count, dtype)
    for name, values in arrays.items():
        rows[name] = values
    log.append(rows)
    log.end(end)
    return file


SHAPES = {
    "flat": lambda a: a.reshape(len(a), -1)[:, 0],
    "wider": lambda a: np.stack([a, a], axis=-1),
    "transposed": lambda a: a.reshape(len(a), -1)[:, :1] * np.ones((1, 7)),
}


@pytest.mark.parametrize("how", SHAPES)
@pytest.mark.parametrize("name", ["time", "q", "v", "com", "foothold", "torque"])
def test_channels_of_other_shapes_are_refused_by_name(tmp_path, name, how):
    changed = {}

    def change(arrays, begin, end):
        changed["same"] = SHAPES[how](arrays[name]).shape == arrays[name].shape
        arrays[name] = SHAPES[how](arrays[name])

    message = refusal(written(tmp_path / LOG, change))
    assert changed["same"] or message
    # What the robot has of each is known of q, v and torque.
    assert changed["same"] or name in message or name in ("q", "v", "torque")


ODD = [None, 7, "x", [], [1.0, "a"], {"a": 1}, True, 2**70]
FACTS = ["version", "scenario", "joint_names", "effort_limits"]
FACTS += ["fell", "fall_time", "fall_reason", "wall_seconds"]


@pytest.mark.parametrize("name", FACTS)
@pytest.mark.parametrize("value", ODD, ids=str)
def test_the_rest_of_a_run_is_checked_as_well(tmp_path, name, value):
    def change(arrays, begin, end):
        (begin if name in begin else end)[name] = value

    message = refusal(written(tmp_path / LOG, change))
    fits = {"version": str, "fall_reason": str, "fell": bool, "fall_time": type(None)}
    if not isinstance(value, fits.get(name, ())) and (name, value) != ("wall_seconds", 7):
        assert message


@pytest.mark.parametrize("name", FACTS)
def test_each_fact_is_needed(tmp_path, name):
    def change(arrays, begin, end):
        del (begin if name in begin else end)[name]

    assert name in refusal(written(tmp_path / LOG, change))


@pytest.mark.parametrize("time", [-TIME, TIME[::-1], TIME * np.nan, TIME * 1e300, TIME * 0.0])
def test_times_go_on_from_the_beginning(tmp_path, time):
    assert "time" in refusal(
        written(tmp_path / LOG, lambda arrays, begin, end: arrays.update(time=time))
    )


def test_each_channel_is_needed(tmp_path):
    for name in CHANNELS:
        file = written(tmp_path / LOG, lambda arrays, begin, end, name=name: arrays.pop(name))
        assert name in refusal(file)


def test_a_log_of_another_format_is_refused(tmp_path, monkeypatch):
    """Of a later version, say."""
    monkeypatch.setattr(log_module, "FORMAT", "drake_linefoot.log.3")
    written(tmp_path / LOG)
    monkeypatch.undo()
    assert "another format" in refusal(tmp_path / LOG)


def test_damage_is_found_when_a_channel_is_used(tmp_path):
    """A number of the position is another one; all else can be used."""
    com = np.full((len(TIME), 3), 0.123456789)

    def change(arrays, begin, end):
        arrays["com"] = com

    file = written(tmp_path / LOG, change)
    changed = bytearray(file.read_bytes())
    changed[changed.index(com[:1].tobytes()) + 9] ^= 1
    file.write_bytes(changed)
    run = Run.load(file)
    np.testing.assert_array_equal(run.time, TIME)
    with pytest.raises(InputError, match="com = 'recorded run': is damaged"):
        _ = run.com


def test_a_device_or_a_folder_is_no_recording(tmp_path):
    (tmp_path / "zero.arrow").symlink_to("/dev/zero")
    (tmp_path / "folder.arrow").mkdir()
    for name in ("zero.arrow", "folder.arrow"):
        assert refusal(tmp_path / name)


def test_facts_are_plain_json():
    """So that a log can be described without us."""
    begin, end = make_run(TIME).facts()
    assert json.loads(json.dumps([begin, end])) == [begin, end]
    assert set(WALL_TIMES) < set(CHANNELS)
