"""What goes between robot and controller over LCM, and how it is packed.

The declarations below are also files in LCM's own language, `messages.lcm`, from which `lcm-gen`
makes types in other languages; `lcm_text` writes them.
"""

import re
import struct
from collections.abc import Iterator
from functools import cache
from typing import Annotated, Any, NamedTuple, TypeVar, get_type_hints

import numpy as np
from numpy.typing import NDArray

PACKAGE = "linefoot"
HOLD, DAMP = 0, 1  # modes: apply the effort; brake with the damping, without an effort
_BITS = (1 << 64) - 1
_CODES = {"int64_t": "q", "int32_t": "i", "int8_t": "b", "double": "d"}

Stamp = Annotated[int, "int64_t"]
Count = Annotated[int, "int64_t"]
Small = Annotated[int, "int8_t"]
Real = Annotated[float, "double"]
Text = Annotated[str, "string"]
Doubles = NDArray[np.float64]


class RobotOutput(NamedTuple):
    """What the robot says, once a tick."""

    utime: Stamp  # of the state [us]
    seq: Count  # 0 where the robot begins, then one more each tick
    position: Annotated[Doubles, "double", "num_positions"]  # q, as Drake has it
    velocity: Annotated[Doubles, "double", "num_velocities"]  # v, as Drake has it
    effort: Annotated[Doubles, "double", "num_efforts"]  # applied in the tick before [N m]
    imu: Annotated[Doubles, "double", 6]  # angular velocity [rad/s], specific force [m/s^2], in B


class RobotInput(NamedTuple):
    """What the controller answers."""

    utime: Stamp  # of the state that is answered [us]
    seq: Count  # likewise
    mode: Small  # 0: apply the effort; 1: brake the joints
    effort: Annotated[Doubles, "double", "num_efforts"]  # torques until the next answer [N m]
    damping: Annotated[Doubles, "double", "num_dampings"]  # of the joints, to brake [N m s/rad]


class WalkCommand(NamedTuple):
    """What somebody wants the robot to do; it stops when none comes for half a second."""

    utime: Stamp  # on the robot's clock [us]
    velocity: Annotated[Doubles, "double", 2]  # forward and left [m/s]
    turn_rate: Real  # counter-clockwise [rad/s]
    walk: Small  # 0: stand on both feet


class ControllerStatus(NamedTuple):
    """How the controller is, ten times a second."""

    utime: Stamp  # of the last state [us]
    seq: Count  # likewise
    contact: Annotated[Doubles, "double", 2]  # left and right foot: 1 where it is loaded
    refused: Count  # states with a number that is not finite, or of another size
    old: Count  # states that came after a newer one
    missed: Count  # states that never came
    begun: Count  # how often it has begun
    unsolved: Count  # plans since then that the MPC has not found
    worst_tick: Real  # longest time of an answer since the last status [ms]
    fault: Text  # what is wrong now; empty when nothing is


KINDS = {"ROBOT_OUTPUT": RobotOutput, "ROBOT_INPUT": RobotInput}
KINDS |= {"WALK_COMMAND": WalkCommand, "CONTROLLER_STATUS": ControllerStatus}
Kind = TypeVar("Kind", bound=tuple[Any, ...])


class _Field(NamedTuple):
    """A field as LCM has it."""

    name: str
    type: str
    size: str | int | None = None  # name of the field with the length of an array, or that length


@cache
def _fields(kind: type[tuple[Any, ...]]) -> tuple[_Field, ...]:
    """Return the fields of a message, before each array the one with its length."""
    found = list[_Field]()
    for name, hint in get_type_hints(kind, include_extras=True).items():
        field = _Field(name, *hint.__metadata__)
        if isinstance(field.size, str):
            found.append(_Field(field.size, "int32_t"))
        found.append(field)
    return tuple(found)


def encode(message: tuple[Any, ...]) -> bytes:
    """Return a message as LCM packs it."""
    parts, kind = [struct.pack(">Q", fingerprint(type(message)))], type(message)
    for field in _fields(kind):
        if (sized := _array_of(kind, field.name)) is not None:
            parts.append(struct.pack(">i", len(getattr(message, sized))))
        elif field.type == "string":
            text = getattr(message, field.name).encode("utf-8") + b"\0"
            parts.append(struct.pack(">i", len(text)) + text)
        elif field.size is not None:
            values = np.asarray(getattr(message, field.name), dtype=">f8")
            if isinstance(field.size, int) and values.shape != (field.size,):
                raise ValueError(f"{field.name} must have {field.size} numbers")
            parts.append(values.tobytes())
        else:
            parts.append(struct.pack(">" + _CODES[field.type], getattr(message, field.name)))
    return b"".join(parts)


def decode(kind: type[Kind], data: bytes) -> Kind:
    """Return the message of a kind that LCM has packed.

    Raises:
        ValueError: it is another one, or cut off.
    """
    if data[:8] != struct.pack(">Q", fingerprint(kind)):
        raise ValueError(f"is no {kind.__name__}")
    at, lengths, values = 8, dict[str, int](), dict[str, Any]()
    try:
        for field in _fields(kind):
            if field.type == "string":
                (length,) = struct.unpack_from(">i", data, at)
                values[field.name] = data[at + 4 : at + 3 + length].decode("utf-8")
                at += 4 + length
            elif field.size is not None:
                size = lengths[field.size] if isinstance(field.size, str) else field.size
                found = np.frombuffer(data, ">f8", size, at).astype(float)
                values[field.name], at = found, at + found.nbytes
            else:
                code = ">" + _CODES[field.type]
                (value,) = struct.unpack_from(code, data, at)
                at += struct.calcsize(code)
                sized = _array_of(kind, field.name) is not None
                (lengths if sized else values)[field.name] = value
    except (struct.error, UnicodeDecodeError, ValueError) as error:
        raise ValueError(f"{kind.__name__} is cut off or damaged: {error}") from error
    if at != len(data):
        raise ValueError(f"{kind.__name__} is cut off or damaged: {len(data) - at} bytes left")
    return kind(**values)


@cache
def _array_of(kind: type[tuple[Any, ...]], name: str) -> str | None:
    """Return the array whose length a field has; None where it is a field of the message."""
    arrays = {field.size: field.name for field in _fields(kind)}
    return arrays.get(name)


@cache
def fingerprint(kind: type[tuple[Any, ...]]) -> int:
    """Return what tells a kind of message from others: LCM's hash of names, types and sizes."""
    value = 0x12345678
    for byte in _hashed(kind):
        signed = value - (1 << 64) if value >> 63 else value
        value = (((value << 8) & _BITS) ^ ((signed >> 55) & _BITS)) + byte & _BITS
    return ((value << 1) & _BITS) + (value >> 63) & _BITS


def _hashed(kind: type[tuple[Any, ...]]) -> Iterator[int]:
    def text(word: str) -> Iterator[int]:
        yield len(word)
        yield from word.encode("ascii")

    for field in _fields(kind):
        yield from text(field.name)
        yield from text(field.type)
        yield 0 if field.size is None else 1  # dimensions
        if field.size is not None:
            yield 1 if isinstance(field.size, str) else 0  # of variable or constant length
            yield from text(str(field.size))


def lcm_text() -> str:
    """Return the declarations in LCM's language."""
    lines = [f"package {PACKAGE};"]
    for kind in KINDS.values():
        words = re.findall("[A-Z][a-z]*", kind.__name__)
        name = "_".join(words).lower()
        lines += ["", f"// {kind.__doc__}", f"struct {name} {{"]
        for field in _fields(kind):
            size = "" if field.size is None else f"[{field.size}]"
            lines.append(f"  {field.type} {field.name}{size};")
        lines.append("}")
    return "\n".join(lines) + "\n"
