"""Recordings whose structure is odd: what can be read is read, the rest is one line each."""

import io
import json
from dataclasses import replace
from types import SimpleNamespace
from zlib import crc32

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_linefoot.errors import InputError
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.results.report import report_html
from drake_linefoot.lab.results.tables import log_table
from drake_linefoot.lab.scenario import Segment
from drake_linefoot.lab.simulation.log import MOST
from drake_linefoot.lab.simulation.mcap_log import MCAP, METADATA, write_mcap
from drake_linefoot.lab.simulation.recording import CHANNELS, LOG, Run
from drake_linefoot.lab.visualization.replay import play
from tests.helpers.recorded_runs import make_run, mcap_log
from tests.lab.simulation.test_damaged_recordings import TIME, refusal, written

SHRUNK = {"nq": 22, "nv": 21, "na": 15, "nw": 5, "nc": 2}  # three actuators fewer


def sized(sizes):
    """Return what changes a recording to that of a robot of some sizes."""

    def change(arrays, begin, end):
        for name, channel in CHANNELS.items():
            if name != "time":  # every sample like the first
                row = np.resize(arrays[name][0], channel.shape(sizes))
                arrays[name] = np.broadcast_to(row, (len(TIME), *row.shape))
        for entry in ("joint_names", "effort_limits"):
            begin[entry] = (2 * begin[entry])[: sizes["na"]]

    return change


def uses(folder):
    """Return everything that reads a recording, by name."""
    run = Run.load(folder / LOG)
    return {
        "table": lambda: log_table(folder),
        "mcap": lambda: write_mcap(run, io.BytesIO()),
        "metrics": lambda: compute_metrics(run),
        "report": lambda: report_html(run, compute_metrics(run), {}),
        "pandas": run.to_pandas,
        "facts": lambda: repr(run),
        "replay": lambda: play(run, None),
    }


@pytest.mark.parametrize(
    ("entry", "value"),
    [
        *(("wall_seconds", odd) for odd in (-1.0, float("nan"), float("inf"))),
        *(("fall_time", odd) for odd in (float("nan"), float("inf"), -1.0, 0.005)),
        ("fell", True),
        *(("effort_limits", [odd] * 18) for odd in (0.0, -1.0, float("nan"), 1e308)),
        *(("joint_names", [odd] * 18) for odd in ("", "\ud800", "\x1b]0;pwned\a", "x" * 100_000)),
        *(("fall_reason", odd) for odd in ("\ud800", "\x1b[2J", "x" * 100_000)),
        *(("version", odd) for odd in ("", "\udcff", "\x1b[2J", "x" * 100_000)),
        *(("scenario", odd) for odd in ("name: a", [], {"name": "\ud800"}, {"name": "\x1b[2J"})),
        ("scenario", {"segments": [{"duration": "x" * 100_000}]}),
    ],
)
def test_a_fact_that_is_none_is_named(tmp_path, entry, value):
    def change(arrays, begin, end):
        (begin if entry in begin else end)[entry] = value

    message = refusal(written(tmp_path / LOG, change))
    assert entry in message or entry in ("fell", "scenario")
    assert message.isprintable()
    assert message


def test_a_run_without_wall_time_can_be_used(tmp_path):
    file = written(tmp_path / LOG, lambda arrays, begin, end: end.update(wall_seconds=0.0))
    assert compute_metrics(Run.load(file))["realtime_rate"] == 0.0


@pytest.mark.parametrize("step", [1e-300, 5e-324, 1e-9, 2.0])
def test_steps_that_no_run_has_are_named_with_their_sample(tmp_path, step):
    def change(arrays, begin, end):
        arrays["time"] = np.arange(len(TIME)) * step

    assert "time[1]" in refusal(written(tmp_path / LOG, change))


@pytest.mark.parametrize("sizes", [SHRUNK, {**SHRUNK, "nq": 8, "nv": 7, "na": 1}])
def test_a_robot_of_other_sizes_is_said_wherever_it_matters(tmp_path, sizes):
    written(tmp_path / LOG, sized(sizes))
    for name, use in uses(tmp_path).items():
        if name in ("table", "facts"):
            use()
            continue
        with pytest.raises(InputError, match="robot = 'mit_humanoid'"):
            use()


@pytest.mark.parametrize(("nw", "nc"), [(1, 1), (3, 1), (4, 2), (5, 3), (5, 4), (6, 2), (40, 2)])
def test_contacts_of_no_kind_are_refused(tmp_path, nw, nc):
    sizes = {"nq": 25, "nv": 24, "na": 18, "nw": nw, "nc": nc}
    assert "contact_wrench, true_normal" in refusal(written(tmp_path / LOG, sized(sizes)))


@pytest.mark.parametrize("name", ["q", "v", "com", "true_force", "contact_points"])
def test_a_number_that_is_missing_is_named_with_its_sample(tmp_path, name):
    def change(arrays, begin, end):
        arrays[name] = arrays[name].copy()
        arrays[name][7] = np.nan

    file = written(tmp_path / LOG, change)
    assert f"{name}[7] = nan" in refusal(file)
    np.testing.assert_array_equal(Run.load(file).torque, np.zeros((len(TIME), 18)))


def test_a_quaternion_of_another_norm_is_named(tmp_path):
    def change(arrays, begin, end):
        arrays["q"] = arrays["q"] * np.where(np.arange(len(TIME)) == 3, 0.0, 1.0)[:, None]

    assert "q[3] = 0.0" in refusal(written(tmp_path / LOG, change))


@pytest.mark.parametrize("count", [0, 1, 2])
def test_a_log_of_few_samples_can_be_used(tmp_path, count):
    def change(arrays, begin, end):
        arrays.update({name: values[:count] for name, values in arrays.items()})

    written(tmp_path / LOG, change)
    for name, use in uses(tmp_path).items():
        if count == 0 and name in ("report", "replay"):
            with pytest.raises(InputError, match="0 samples"):
                use()
        elif name != "replay":
            use()


def test_a_run_with_few_samples_a_second_has_a_report(tmp_path):
    """As `--log 1` writes it."""
    file = written(
        tmp_path / LOG, lambda arrays, begin, end: arrays.update(time=np.arange(len(TIME)) * 1.0)
    )
    run = Run.load(file)
    assert "10.000 s" in report_html(run, compute_metrics(run), {})


def signed(said):
    text = json.dumps(said).encode()
    return {b"drake_linefoot": text, b"crc32": str(crc32(text)).encode()}


JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**70), 2**70) | st.floats() | st.text(max_size=9),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=9), inner, max_size=3)
    ),
    max_leaves=6,
)
KINDS = [pa.float16(), pa.float32(), pa.int64(), pa.string(), pa.list_(pa.float64())]
KINDS += [pa.list_(pa.float64(), n) for n in (1, 2, 7, 25)] + [pa.float64()]


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_layouts_and_metadata_of_all_kinds_are_read_or_refused(tmp_path_factory, whole, data):
    """With checksums that are right: what they say is looked at."""
    stream = pa.ipc.open_stream(whole.read_bytes())
    head, rows = json.loads(stream.schema.metadata[b"drake_linefoot"]), []
    fields = {name: stream.schema.field(name) for name in stream.schema.names}
    for _ in range(data.draw(st.integers(0, 2))):
        name = data.draw(st.sampled_from(sorted(fields)))
        fields[name] = pa.field(name, data.draw(st.sampled_from(KINDS)), True)
        if data.draw(st.booleans()):
            head["shapes"][name] = data.draw(JSON | st.lists(st.integers(0, 9), max_size=3))
    for _ in range(data.draw(st.integers(0, 2))):
        facts = head["facts"]
        where = data.draw(
            st.sampled_from([head, facts] if facts and type(facts) is dict else [head])
        )
        where[data.draw(st.sampled_from(sorted(where)))] = data.draw(JSON)
    schema = pa.schema(list(fields.values()), signed(head))
    file = tmp_path_factory.getbasetemp() / "odd.arrow"
    file.unlink(missing_ok=True)
    with pa.OSFile(str(file), "wb") as sink, pa.ipc.new_stream(sink, schema) as out:
        while True:
            try:
                batch, more = stream.read_next_batch_with_custom_metadata()
            except StopIteration:
                break
            says = json.loads(more[b"drake_linefoot"])
            if data.draw(st.integers(0, 4)) == 0:
                says[data.draw(st.sampled_from(sorted(says)))] = data.draw(JSON)
            columns = [
                column if kind.type == column.type else pa.nulls(len(batch), kind.type)
                for column, kind in zip(batch.columns, fields.values(), strict=True)
            ]
            changed = pa.RecordBatch.from_arrays(columns, schema=schema)
            rows.append(len(batch))
            out.write_batch(changed, custom_metadata=signed(says))
    if not refusal(file):
        assert len(Run.load(file).time) <= sum(rows)


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_any_run_that_can_be_made_is_read_as_it_was(tmp_path_factory, data):
    n, period = data.draw(st.integers(1, 40)), data.draw(st.floats(1e-5, 1.0))
    time = np.arange(n) * period
    numbers = st.floats(width=64)
    given = {}
    for name in data.draw(st.sets(st.sampled_from(sorted(CHANNELS)), max_size=4)):
        if name not in ("time", "q"):
            shape = getattr(make_run(time), name).shape
            value = data.draw(st.floats(-MOST, MOST) if name in SOUND else numbers)
            given[name] = np.full(shape, value)
    texts = st.text(st.characters(categories=["L", "N", "P", "S"]), min_size=1, max_size=40)
    segments = [
        Segment(data.draw(texts), data.draw(st.floats(1e-3, 1e3)), data.draw(st.booleans()))
        for _ in range(data.draw(st.integers(1, 4)))
    ]
    fell = data.draw(st.booleans())
    run = make_run(time, fell, segments, **given)
    reason, wall = data.draw(st.text()) if fell else "", data.draw(st.floats(0.0, 1e6))
    run = replace(run, fall_reason=reason, wall_seconds=wall)
    file = tmp_path_factory.getbasetemp() / LOG
    file.unlink(missing_ok=True)
    run.save(file)
    again = Run.load(file)
    for name in CHANNELS:
        written_as = np.clip(getattr(run, name), -MOST, MOST)
        np.testing.assert_array_equal(getattr(again, name), written_as, err_msg=name)
    assert again.scenario == run.scenario
    assert (again.fell, again.fall_time, again.wall_seconds) == (fell, run.fall_time, wall)
    assert again.fall_reason.isprintable()


SOUND = ("v", "com", "contact_points", "true_force", "true_normal", "slip_speed")


def test_an_mcap_log_that_is_damaged_is_one_line(tmp_path):
    """Every byte of its end, where what is looked at lies, and a few of the rest."""
    make_run(TIME).save(tmp_path / LOG)
    good = mcap_log(make_run(TIME))
    rng, ends = np.random.default_rng(0), {"taken": 0, "refused": 0}
    for at in [*range(len(good) - 400, len(good), 3), *rng.integers(len(good), size=60)]:
        changed = bytearray(good)
        changed[at] ^= 1 << int(rng.integers(8))
        (tmp_path / MCAP).write_bytes(changed)
        try:
            log_table(tmp_path)
            ends["taken"] += 1
        except InputError as error:
            assert str(error).isprintable()
            ends["refused"] += 1
    assert min(ends.values()) > 10


@pytest.mark.parametrize("step", ["", "x", "-1", "1e3", "9" * 5000])
def test_metadata_of_an_mcap_log_is_checked(tmp_path, monkeypatch, step):
    make_run(TIME).save(tmp_path / LOG)
    good = mcap_log(make_run(TIME))
    odd = SimpleNamespace(name=METADATA, metadata={"samples_per_message": step})
    monkeypatch.setattr("mcap.reader.SeekingReader.iter_metadata", lambda self: iter([odd]))
    (tmp_path / MCAP).write_bytes(good)
    with pytest.raises(InputError, match="metadata drake_linefoot"):
        log_table(tmp_path)
