"""Signals on the ports of a block: put there and looked at by their parts."""

from functools import cache

from drake_linefoot.layout import Layout, flat
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.signals import SIGNALS


def layout_of(port, robot=None, name=None):
    """The layout of the signal on a port; the knots follow from its size."""
    sizes = _usual_sizes() if robot is None else tuple(robot.sizes.items())
    return _layout(name or port.get_name(), port.size(), sizes)


def look(port, context, robot=None, name=None):
    """Evaluate a port and open its signal; `name` of the signal, if it is not the port's."""
    return layout_of(port, robot, name).open(port.Eval(context))


def put(system, context, name, signal):
    """Fix an input port to a signal."""
    system.GetInputPort(name).FixValue(context, flat(signal))


@cache
def _usual_sizes():
    return tuple(load_humanoid("mit_humanoid").sizes.items())


@cache
def _layout(name, size, sizes):
    for knots in range(1, 201):
        layout = Layout(SIGNALS[name], dict(sizes) | {"knots": knots})
        if layout.size == size:
            return layout
    raise AssertionError(f"no {SIGNALS[name].__name__} has {size} numbers")
