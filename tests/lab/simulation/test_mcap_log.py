"""The MCAP log, read with the public reader: names, types, units, counts, times, values."""

import io
import json

import numpy as np
import pytest
from mcap.reader import make_reader

from drake_linefoot.errors import InputError
from drake_linefoot.lab.scenario.load import parse_scenario
from drake_linefoot.lab.simulation.mcap_log import METADATA, SCENARIO
from drake_linefoot.lab.simulation.recording import CHANNELS
from tests.helpers.recorded_runs import make_run, mcap_log, short_run

NAMES = {*CHANNELS, "rpy"} - {"time"}
UNITS = {"-", "m", "rad", "m/s", "rad/s", "m/s^2", "rad/s^2", "N", "N m", "ms"}
UNITS |= {"kg m^2/s"}
TIME = np.arange(101) * 1e-3


class Log:
    """What the public reader finds in JSON; `test_mcap_scene` reads the scene."""

    def __init__(self, content):
        reader = make_reader(io.BytesIO(content), validate_crcs=True)
        self.summary = reader.get_summary()
        self.messages, self.order = {}, []
        self.channels = {
            c.topic: c for c in self.summary.channels.values() if c.message_encoding == "json"
        }
        for _, channel, message in reader.iter_messages(topics=list(self.channels)):
            rows = self.messages.setdefault(channel.topic, [])
            rows.append((message.log_time, json.loads(message.data)))
            self.order.append(message.log_time)
        self.schemas = {
            topic: self.summary.schemas[c.schema_id] for topic, c in self.channels.items()
        }
        self.metadata = {m.name: m.metadata for m in reader.iter_metadata()}
        self.attachments = {a.name: a.data.decode() for a in reader.iter_attachments()}


@pytest.fixture(scope="module")
def log():
    return Log(mcap_log(short_run(), 200.0))


def leaves(schema, path=()):
    """Paths and schemas of the numbers of a message."""
    if schema["type"] != "object":
        yield path, schema
    for name, inner in schema.get("properties", {}).items():
        yield from leaves(inner, (*path, name))


def numbers(message, path=()):
    for name, inner in message.items():
        if isinstance(inner, dict):
            yield from numbers(inner, (*path, name))
        else:
            yield (*path, name), inner


def test_every_channel_is_a_topic_with_a_schema_and_its_unit(log):
    assert set(log.channels) == {f"/{name}" for name in NAMES}
    for topic, channel in log.channels.items():
        assert channel.message_encoding == "json"
        assert log.schemas[topic].encoding == "jsonschema"
        assert log.schemas[topic].name == topic[1:]
        assert channel.metadata["unit"] == short_run().unit(topic[1:])


def test_every_number_has_a_type_and_one_unit(log):
    for topic, schema in log.schemas.items():
        for path, leaf in leaves(json.loads(schema.data)):
            assert leaf["type"] in {"number", "integer"}, (topic, path)
            assert leaf["unit"] in UNITS, (topic, path)
            assert leaf["description"] == leaf["unit"]


def test_messages_are_what_their_schema_says(log):
    kinds = {"number": (int, float), "integer": int}
    for topic, rows in log.messages.items():
        schema = dict(leaves(json.loads(log.schemas[topic].data)))
        for _, message in rows:
            found = dict(numbers(message))
            assert found.keys() <= schema.keys()
            for path, value in found.items():
                assert isinstance(value, kinds[schema[path]["type"]]), (topic, path, value)


def test_only_flags_counts_and_statuses_are_whole(log):
    """Also a share without a unit keeps its fraction."""
    kinds = {
        topic[1:]: {leaf["type"] for _, leaf in leaves(json.loads(schema.data))}
        for topic, schema in log.schemas.items()
    }
    integers = {name for name, kind in kinds.items() if kind == {"integer"}}
    assert {"mode", "planned_contact", "gait_steps", "mpc_success", "contact_flag"} <= integers
    shares = {"reference_friction", "reference_friction_share", "estimate_nis"}
    assert not shares & integers
    run = short_run()
    for name in integers:
        values = getattr(run, name)
        values = values[np.isfinite(values)]
        np.testing.assert_array_equal(values, np.round(values), err_msg=name)


def test_units_of_mixed_channels(log):
    def unit(topic, *path):
        return dict(leaves(json.loads(log.schemas[topic].data)))[path]["unit"]

    assert [unit("/q", n) for n in ("q_w", "z", "left_knee")] == ["-", "m", "rad"]
    assert [unit("/v", n) for n in ("w_x", "v_z", "left_knee")] == ["rad/s", "m/s", "rad/s"]
    assert [unit("/mpc_wrench", "left", n) for n in ("f_z", "tau_y")] == ["N", "N m"]
    assert [unit("/foothold", "right", n) for n in ("z", "yaw")] == ["m", "rad"]
    assert [unit("/command", n) for n in ("v_y", "turn_rate", "walk")] == ["m/s", "rad/s", "-"]
    assert [unit("/acceleration_error", n) for n in ("angular_x", "x")] == ["rad/s^2", "m/s^2"]


def test_counts_rate_and_timestamps(log):
    run = short_run()
    assert len(run.time) in {400, 401}
    counts = log.summary.statistics.channel_message_counts
    by_topic = {topic: counts.get(c.id, 0) for topic, c in log.channels.items()}
    assert by_topic == {topic: len(log.messages.get(topic, ())) for topic in log.channels}
    times = np.array([time for time, _ in log.messages["/com"]])
    np.testing.assert_array_equal(times, np.arange(len(times)) * 5_000_000)
    assert times[-1] <= 1e9 * run.time[-1] < times[-1] + 5_000_000
    assert log.order == sorted(log.order)


def test_values_are_those_of_the_run(log):
    run = short_run()
    com = np.array([[m["x"], m["y"], m["z"]] for _, m in log.messages["/com"]])
    np.testing.assert_allclose(com, run.com[::5], rtol=1e-5)
    knee = run.joint_names.index("left_knee")
    torque = np.array([m["left_knee"] for _, m in log.messages["/torque"]])
    np.testing.assert_allclose(torque, run.torque[::5, knee], rtol=1e-5)
    heel = np.array([m["right"]["heel"]["z"] for _, m in log.messages["/contact_points"]])
    np.testing.assert_allclose(heel, run.contact_points[::5, 1, 0, 2], rtol=1e-5)
    mode = np.array([m["value"] for _, m in log.messages["/mode"]])
    np.testing.assert_array_equal(mode, run.mode[::5])


def test_a_rare_channel_keeps_all_its_values(log):
    run = short_run()
    known = ~np.isnan(run.mpc_ms)
    stored = [m["value"] for _, m in log.messages["/mpc_ms"]]
    np.testing.assert_allclose(stored, run.mpc_ms[known], rtol=1e-5)


def test_without_limit_every_sample_is_there():
    run = short_run()
    assert len(Log(mcap_log(run, 1000.0)).messages["/com"]) == len(run.time)


def test_numbers_that_are_not_there_are_left_out():
    com = np.zeros((len(TIME), 3))
    com[:50] = np.nan
    com[60:, 1] = np.nan
    com[70:, 2] = np.inf
    log = Log(mcap_log(make_run(TIME, com=com), 1000.0))
    assert [time for time, _ in log.messages["/com"]] == [int(t) * 10**6 for t in range(50, 101)]
    messages = [m for _, m in log.messages["/com"]]
    assert messages[0] == {"x": 0.0, "y": 0.0, "z": 0.0}
    assert messages[15] == {"x": 0.0, "z": 0.0}
    assert messages[-1] == {"x": 0.0}


def test_scenario_version_and_fall_are_in_it():
    run = make_run(TIME, fell=True)
    log = Log(mcap_log(run))
    assert parse_scenario(log.attachments[SCENARIO], "log") == run.scenario
    facts = log.metadata[METADATA]
    assert (facts["fell"], facts["fall_time"]) == ("true", "0.100 s")
    assert (facts["fall_reason"], facts["samples_per_message"]) == ("torso low", "5")


def test_it_is_smaller_than_the_numbers(monkeypatch):
    run = short_run()
    raw = sum(getattr(run, name).nbytes for name in CHANNELS)
    whole = len(mcap_log(run))
    monkeypatch.setattr("drake_linefoot.lab.simulation.mcap_log.Scene.messages", lambda *_: [])
    numbers_alone = len(mcap_log(run))
    assert numbers_alone < 0.3 * raw
    assert whole - numbers_alone < 120_000  # the robot, most of it, once


@pytest.mark.parametrize("length", [1, 2])
def test_a_run_of_a_few_samples(length):
    assert len(Log(mcap_log(make_run(TIME[:length] + 0.0))).messages["/com"]) == 1


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan")])
def test_a_rate_that_is_none_is_refused(rate):
    with pytest.raises(InputError, match=r"must be a number from 0\.001 to 1e"):
        mcap_log(make_run(TIME), rate)
