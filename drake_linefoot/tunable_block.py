"""A block whose parameters can be changed in its context, which Drake's numeric parameters are."""

from collections.abc import Callable
from typing import Any, Generic, TypeVar

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DependencyTicket,
    NumericParameterIndex,
    ValueProducer,
)

from drake_linefoot.checks import check, plain
from drake_linefoot.errors import InputError
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.parameters import numbers_of, with_numbers

_P = TypeVar("_P")
_C = TypeVar("_C")


class TunableBlock(Block, Generic[_P, _C]):
    """A block with parameters in its context, and constants made of them.

    The numbers of its dataclass of parameters (`drake_linefoot.fields.tunable`) are one vector,
    Drake's numeric parameter 0, in the size of the robot. A text, a flag, a count, and what says
    how large or how often something is, stay those that the block was built with.

    Attributes:
        parameter_names: of the numbers of the vector, as "weights.position[0]".
    """

    parameter_names: tuple[str, ...]

    def declare_parameters(self, parameters: _P, make: Callable[[_P], _C]) -> DependencyTicket:
        """Declare the vector, and the constants as what the context caches.

        Args:
            parameters: a dataclass, in the size of the robot.
            make: constants of such; plain data, for contexts are copied with it.

        Returns:
            The ticket of the constants, for output ports that are computed with them.
        """
        self._parameters, self._make_constants = parameters, make
        numbers = numbers_of(parameters)
        self.parameter_names, self._numbers = tuple(numbers), np.array([*numbers.values()])
        index = NumericParameterIndex(self.DeclareNumericParameter(BasicVector(self._numbers)))
        self._constants_entry = self.DeclareCacheEntry(
            description="constants",
            value_producer=ValueProducer(
                allocate=Value[object], calc=weak(self, self._calc_constants)
            ),
            prerequisites_of_calc={self.numeric_parameter_ticket(index)},
        )
        return self._constants_entry.ticket()

    def parameters(self, context: Context) -> _P:
        """Return the parameters in force, in the size of the robot.

        Args:
            context: of this system.

        Raises:
            InputError: its vector holds a number that is not allowed.
        """
        numbers = context.get_numeric_parameter(0).value()
        parameters = with_numbers(self._parameters, numbers)
        if np.array_equal(numbers, self._numbers):
            return parameters  # which the block was built with
        return self._checked(parameters)

    def set_parameters(self, context: Context, **changes: Any) -> None:
        """Change parameters from the next update on: `set_parameters(context, swing_height=0.08)`.

        Args:
            context: of this system.
            changes: new values by name; a part may be a mapping of what of it changes, as
                `weights={"force": 2e-5}`.

        Raises:
            InputError: a name or a value is not allowed; nothing is changed then.
        """
        now = self.parameters(context)
        new = self._checked(_merged(plain(now), plain(changes)))
        numbers = list(numbers_of(new).values())
        kept = with_numbers(now, numbers)
        for name, value in changes.items():
            if getattr(kept, name) != getattr(new, name):
                allowed = "is what the block is built with; a context has no other"
                raise InputError(self.get_name(), name, value, allowed)
        try:
            self._make_constants(new)
        except (ArithmeticError, ValueError) as error:
            raise InputError(self.get_name(), "", changes, f"cannot be: {error}") from error
        context.get_mutable_numeric_parameter(0).SetFromVector(numbers)

    def constants_in(self, context: Context) -> _C:
        """Return the constants of the parameters in force; otherwise as `parameters`."""
        constants: _C = self._constants_entry.EvalAbstract(context).get_value()
        return constants

    def _calc_constants(self, context: Context, value: Any) -> None:
        value.set_value(self._make_constants(self.parameters(context)))

    def _checked(self, parameters: Any) -> _P:
        kind = type(self._parameters)
        return check(plain(parameters), kind, self.get_name(), error=InputError)


def _merged(data: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Return nested mappings with some entries changed."""
    inner = {
        name: _merged(data[name], value)
        for name, value in changes.items()
        if isinstance(value, dict) and isinstance(data.get(name), dict)
    }
    return data | changes | inner
