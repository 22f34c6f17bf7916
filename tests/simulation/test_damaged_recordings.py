"""Recordings that are damaged, cut, forged or of other shapes: one error each, of one line."""

import resource
import struct
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_linefoot.errors import InputError
from drake_linefoot.simulation.recording import CHANNELS, Run
from tests.helpers.recorded_runs import make_run

TIME = np.arange(11) * 1e-3


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    """The bytes of a recording."""
    file = tmp_path_factory.mktemp("whole") / "log.npz"
    make_run(TIME).save(file)
    return file.read_bytes()


def refusal(file):
    """Return the message with which a recording is refused, "" when it is not."""
    try:
        Run.load(file)
    except InputError as error:
        message = str(error)
        assert message.startswith(str(file))
        assert "\n" not in message
        assert len(message) < len(str(file)) + 300
        return message
    return ""


@settings(max_examples=150)
@given(data=st.data())
def test_flipped_and_cut_recordings_are_read_right_or_refused(tmp_path_factory, content, data):
    changed = bytearray(content)
    for at in data.draw(st.lists(st.integers(0, len(content) - 1), max_size=4)):
        changed[at] ^= 1 << data.draw(st.integers(0, 7))
    del changed[data.draw(st.none() | st.integers(0, len(content))) or len(content) :]
    file = tmp_path_factory.getbasetemp() / "flipped.npz"
    file.write_bytes(changed)
    if not refusal(file):
        again = Run.load(file)
        np.testing.assert_array_equal(again.time, TIME)


def stored(tmp_path, content):
    (tmp_path / "whole.npz").write_bytes(content)
    with np.load(tmp_path / "whole.npz") as arrays:
        return dict(arrays)


SHAPES = {
    "a row less": lambda a: a[1:],
    "flat": lambda a: a.ravel()[:1],
    "no number": lambda a: a[..., None],
    "a scalar": lambda a: a.ravel()[0],
    "empty": lambda a: a[:0],
    "text": lambda a: a.astype("U5"),
    "complex": lambda a: a.astype(complex),
    "whole": lambda a: a.astype("i1"),
    "records": lambda a: np.zeros(a.shape, [("a", "f8")]),
}


@pytest.mark.parametrize("how", SHAPES)
@pytest.mark.parametrize("name", ["time", "q", "v", "com", "foothold", "mpc_ms"])
def test_channels_of_other_shapes_and_types_are_refused_by_name(tmp_path, content, name, how):
    arrays = stored(tmp_path, content)
    changed = SHAPES[how](arrays[name])
    np.savez(tmp_path / "log.npz", **arrays | {name: changed})
    same = changed.shape == arrays[name].shape and changed.dtype == arrays[name].dtype
    message = refusal(tmp_path / "log.npz")
    assert same or message
    assert same or name in message or name in ("time", "q", "v")  # which say how long others are


@pytest.mark.parametrize("name", ["scenario", "fell", "fall_time", "joint_names", "effort_limits"])
@pytest.mark.parametrize("value", [np.zeros((2, 2)), np.array("x"), np.array([]), np.array(7)])
def test_the_rest_of_a_run_is_checked_as_well(tmp_path, content, name, value):
    np.savez(tmp_path / "log.npz", **stored(tmp_path, content) | {name: value})
    assert refusal(tmp_path / "log.npz")


@pytest.mark.parametrize("time", [-TIME, TIME[::-1], TIME * np.nan, TIME * 1e300, TIME * 0.0])
def test_times_go_on_from_the_beginning(tmp_path, content, time):
    np.savez(tmp_path / "log.npz", **stored(tmp_path, content) | {"time": time})
    assert "time" in refusal(tmp_path / "log.npz")


def test_each_channel_is_needed(tmp_path, content):
    arrays = stored(tmp_path, content)
    later = {name for name, channel in CHANNELS.items() if channel.signal == "estimate"}
    for name in CHANNELS.keys() - {"push", "mpc_horizon"} - later:
        np.savez(tmp_path / "log.npz", **{n: a for n, a in arrays.items() if n != name})
        assert name in refusal(tmp_path / "log.npz")


def test_objects_are_not_unpickled(tmp_path, content):
    arrays = stored(tmp_path, content) | {"com": np.array([print], dtype=object)}
    np.savez(tmp_path / "log.npz", **arrays)
    assert refusal(tmp_path / "log.npz")


def header(shape, dtype="<f8"):
    text = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text


LIMITED = """
import resource, sys
from drake_linefoot.simulation.recording import Run
from drake_linefoot.errors import InputError
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    Run.load(sys.argv[1])
except InputError as error:
    print(error)
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1024)
"""


def bomb(file, content):
    """1 MB that unpacks to 1 GB."""
    zeros = bytes(2**20)
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        with archive.open("com.npy", "w", force_zip64=True) as entry:
            start = header((2**27 // 3, 3))
            entry.write(start)
            for _ in range(2**10):
                entry.write(zeros)


def shape_of_a_forged_header(file, content):
    """An array of which the header says that it is huge."""
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("com.npy", header((10**13, 3)) + bytes(240))


def size_of_a_forged_entry(file, content):
    """The same, and the directory of the archive says so, too."""
    shape_of_a_forged_header(file, content)
    changed = file.read_bytes()
    at = changed.rindex(b"PK\x01\x02")
    file.write_bytes(changed[: at + 24] + struct.pack("<I", 2**31) + changed[at + 28 :])


@pytest.mark.parametrize("forge", [bomb, shape_of_a_forged_header, size_of_a_forged_entry])
def test_a_forged_recording_takes_no_memory(tmp_path, content, forge):
    file = tmp_path / "log.npz"
    forge(file, content)
    assert file.stat().st_size < 2**23
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, file], capture_output=True, text=True, check=True
    )
    message, megabytes = done.stdout.splitlines()
    assert message.startswith(str(file))
    assert int(megabytes) < 300
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < 2**21


def test_a_device_or_a_folder_is_no_recording(tmp_path):
    (tmp_path / "zero.npz").symlink_to("/dev/zero")
    (tmp_path / "folder.npz").mkdir()
    for name in ("zero.npz", "folder.npz"):
        assert "is no file" in refusal(tmp_path / name)
