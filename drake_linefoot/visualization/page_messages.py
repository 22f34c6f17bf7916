"""What a live page may say to Drake's Meshcat, which trusts every byte it gets.

Only what Meshcat's own page sends is passed on, and made anew from its checked parts: clicks of
buttons, values of sliders, the state of a gamepad. The rest is dropped.
"""

import math
from typing import Any

import msgpack

LARGEST_MESSAGE = 4096  # [bytes]; a gamepad with many buttons sends some hundred
LONGEST_NAME = 200  # [letters]
LARGEST_VALUE = 1e6  # [-] of a slider; who reads it knows its range
MOST_BUTTONS, MOST_AXES = 64, 16  # of a gamepad


def checked(message: bytes | str) -> bytes | None:
    """Return a message of a page as it may go to Meshcat; None for one to drop.

    Args:
        message: as it came.
    """
    if isinstance(message, str) or len(message) > LARGEST_MESSAGE:
        return None
    try:
        content = msgpack.unpackb(message)
    except (ValueError, TypeError, msgpack.UnpackException):
        return None
    kept = _kept(content) if isinstance(content, dict) else None
    return None if kept is None else bytes(msgpack.packb(kept))


def _kept(content: dict[Any, Any]) -> dict[str, Any] | None:
    """Return the checked parts of a message; None when it is none that the page sends."""
    kind, name = content.get("type"), content.get("name")
    if not isinstance(name, str) or len(name) > LONGEST_NAME:
        return None
    if kind == "button":
        return {"type": kind, "name": name}
    if kind == "slider":
        value = _numbers([content.get("value")], LARGEST_VALUE, 1)
        return None if value is None else {"type": kind, "name": name, "value": value[0]}
    if kind == "gamepad":
        pad = _gamepad(content.get("gamepad"))
        return None if pad is None else {"type": kind, "name": "", "gamepad": pad}
    return None


def _gamepad(pad: Any) -> dict[str, Any] | None:
    """Return the state of a gamepad; an empty one says that it was taken away."""
    if pad == {}:
        return {}
    if not isinstance(pad, dict) or type(index := pad.get("index")) is not int:
        return None
    buttons = _numbers(pad.get("button_values"), 1.0, MOST_BUTTONS)
    axes = _numbers(pad.get("axes"), 1.0, MOST_AXES)
    if buttons is None or axes is None or not 0 <= index < MOST_BUTTONS:
        return None
    return {"index": index, "button_values": buttons, "axes": axes}


def _numbers(values: Any, largest: float, most: int) -> list[float] | None:
    """Return numbers clipped to +-largest; None when one is not a finite number."""
    if not isinstance(values, list) or len(values) > most:
        return None
    if not all(type(value) in {int, float} and math.isfinite(value) for value in values):
        return None
    return [min(max(float(value), -largest), largest) for value in values]
