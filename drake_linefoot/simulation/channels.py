"""What a recorded channel is: its unit, its shape, and the name of every number in it."""

from __future__ import annotations

from typing import Final

FEET: Final = ("left", "right")
ENDS: Final = ("heel", "toe")
XYZ: Final = ("x", "y", "z")
RPY: Final = ("roll", "pitch", "yaw")
PLACE: Final = ("x", "y", "z", "yaw")
COMMAND: Final = ("v_x", "v_y", "turn_rate", "walk")
WRENCH: Final = ("f_x", "f_y", "f_z", "tau_y", "tau_z")
BASE: Final = ("angular_x", "angular_y", "angular_z", "x", "y", "z")

Axis = tuple[str, ...] | str | int


class Channel:
    """Unit and shape of one sample of a recorded array.

    Attributes:
        unit: of the numbers; with several, separated by ", ", each belongs to one group of
            entries along the last axis, and "-" is none.
        axes: per axis the names of its entries, or how many there are, or the name of that
            number when it depends on the robot ("nq").
        shape: how many entries each axis has, as a number or by name.
    """

    def __init__(self, unit: str, *axes: Axis, groups: tuple[int, ...] = ()) -> None:
        """Keep them.

        Args:
            unit: see above.
            axes: see above.
            groups: how many entries along the last axis have the first unit, the second and
                so on, the last one taking the rest; without, each unit has one entry.
        """
        self.unit, self.axes, self._groups = unit, axes, groups
        self.shape = tuple(len(axis) if isinstance(axis, tuple) else axis for axis in axes)

    @property
    def is_whole(self) -> bool:
        """Whether all its numbers are whole: flags, counts, an index."""
        return self.unit == "-"

    def names(self, sized: dict[str, tuple[str, ...]]) -> list[tuple[str, ...]]:
        """Return the names of the entries along each axis; `sized` has those of "nq", "na"..."""
        found = []
        for axis in self.axes:
            if isinstance(axis, int):
                found.append(tuple(str(i) for i in range(axis)))
            else:
                found.append(sized[axis] if isinstance(axis, str) else axis)
        return found

    def units(self, length: int) -> list[str]:
        """Return the unit of each of the `length` entries along the last axis."""
        units = self.unit.split(", ")
        if len(units) == 1:
            return units * length
        ends = self._groups[:-1] if self._groups else (1,) * (len(units) - 1)
        each = [unit for unit, count in zip(units, ends, strict=False) for _ in range(count)]
        return each + [units[-1]] * (length - len(each))


WRENCHES: Final = Channel("N, N m", FEET, WRENCH, groups=(3, 2))  # one of each foot
