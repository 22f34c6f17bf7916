"""Messages as LCM packs them: against the types that Drake's own wheel brings."""

from typing import Annotated, NamedTuple

import drake
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.lab.remote import messages
from drake_linefoot.lab.remote.messages import KINDS, RobotInput, WalkCommand, decode, encode

FILE = messages.__file__.replace(".py", ".lcm")


def example(kind, seed=0):
    """A message of a kind with numbers that differ."""
    random, values = np.random.default_rng(seed), {}
    for i, field in enumerate(messages._fields(kind)):
        if messages._array_of(kind, field.name) is not None:
            continue
        if field.type == "string":
            values[field.name] = "tick für tick"
        elif field.size is not None:
            size = field.size if isinstance(field.size, int) else int(random.integers(0, 9))
            values[field.name] = random.normal(size=size)
        else:
            values[field.name] = -0.5 * i if field.type == "double" else i
    return kind(**values)


@pytest.mark.parametrize("kind", KINDS.values())
def test_what_is_packed_comes_out_again(kind):
    for seed in range(5):
        message = example(kind, seed)
        again = decode(kind, encode(message))
        for one, other in zip(message, again, strict=True):
            np.testing.assert_array_equal(one, other)
            assert np.asarray(one).dtype == np.asarray(other).dtype


class IiwaCommand(NamedTuple):
    """As in lcmt_iiwa_command.lcm of Drake."""

    utime: Annotated[int, "int64_t"]
    joint_position: Annotated[np.ndarray, "double", "num_joints"]
    joint_torque: Annotated[np.ndarray, "double", "num_torques"]


class Header(NamedTuple):
    """As in lcmt_header.lcm of Drake."""

    seq: Annotated[int, "int32_t"]
    utime: Annotated[int, "int64_t"]
    frame_name: Annotated[str, "string"]


@pytest.mark.parametrize(
    ("message", "theirs"),
    [
        (IiwaCommand(-7, np.array([0.5, -1.0]), np.array([2.0])), "lcmt_iiwa_command"),
        (Header(3, 1 << 40, "tick"), "lcmt_header"),
    ],
)
def test_bytes_are_those_of_lcms_own_types(message, theirs):
    """Which lcm-gen has made, and Drake's wheel brings."""
    kind = getattr(drake, theirs)
    other = kind.decode(encode(message))
    for name, value in zip(message._fields, message, strict=True):
        np.testing.assert_array_equal(getattr(other, name), value)
    assert other.encode() == encode(message)


@pytest.mark.parametrize("kind", KINDS.values())
def test_damaged_messages_are_refused(kind):
    data = encode(example(kind))
    for bad in (b"", data[:4], data[:-1], data + b"\0", b"\0" + data[1:], data[:20]):
        with pytest.raises(ValueError, match=r"is no|cut off or damaged"):
            decode(kind, bad)
    other = RobotInput if kind is WalkCommand else WalkCommand
    with pytest.raises(ValueError, match="is no"):
        decode(other, data)


@given(st.binary(max_size=200))
def test_any_bytes_are_a_message_or_refused(tail):
    for kind in KINDS.values():
        data = encode(example(kind))[:8] + tail
        try:
            decode(kind, data)
        except ValueError:
            pass


def test_the_file_in_lcms_language_is_up_to_date():
    """When this fails, write `lcm_text()` to messages.lcm."""
    with open(FILE, encoding="utf-8") as file:
        assert file.read() == messages.lcm_text()
