"""What a live page may say to Drake's Meshcat, which trusts every byte it gets.

Only what Meshcat's own page sends is passed on, and made anew from its checked parts: clicks of
buttons, values of sliders, the state of a gamepad. The rest is dropped. So is what a driving page
may order of a drive.
"""

import json
import math
from typing import Any

import msgpack

LARGEST_MESSAGE = 4096  # [bytes]; a gamepad with many buttons sends some hundred
LONGEST_NAME = 200  # [letters]
LARGEST_VALUE = 1e6  # [-] of a slider; who reads it knows its range
MOST_BUTTONS, MOST_AXES = 64, 16  # of a gamepad


def checked(message: bytes | str) -> bytes | None:
    """Return a message of a page as it may go to Meshcat; None for one to drop."""
    if isinstance(message, str) or len(message) > LARGEST_MESSAGE:
        return None
    try:
        content = msgpack.unpackb(message)
    except (ValueError, TypeError, msgpack.UnpackException):
        return None
    kept = _kept(content) if isinstance(content, dict) else None
    return None if kept is None else bytes(msgpack.packb(kept))


def order(message: bytes | str) -> dict[str, Any] | None:
    """Return the checked parts of what a driving page orders; None for an order to drop.

    Args:
        message: JSON: an action that was pressed, a slider and its value, the axes of a stick or
            the displacement of a pointer [m], where None lets go.
    """
    if len(message) > LARGEST_MESSAGE:
        return None
    try:
        content = json.loads(message)
    except (ValueError, RecursionError):
        content = None
    if not isinstance(content, dict) or len(content) != 1:
        return None
    ((kind, value),) = content.items()
    if kind == "press":
        return {kind: value} if _is_name(value) else None
    if kind == "set" and isinstance(value, list) and len(value) == 2 and _is_name(value[0]):
        number = _numbers(value[1:], LARGEST_VALUE, 1)
        return None if number is None else {kind: [value[0], *number]}
    if kind in {"stick", "drag"}:
        axes = _numbers(value, 1.0 if kind == "stick" else LARGEST_VALUE, 3)
        return {kind: axes} if value is None or (axes and len(axes) == 3) else None
    return None


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and len(value) <= LONGEST_NAME


def _kept(content: dict[Any, Any]) -> dict[str, Any] | None:
    """Return the checked parts of a message; None when it is none that the page sends."""
    kind, name = content.get("type"), content.get("name")
    if not _is_name(name):
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
    if not all(type(value) in {int, float} and abs(value) < math.inf for value in values):
        return None
    return [float(min(max(value, -largest), largest)) for value in values]
