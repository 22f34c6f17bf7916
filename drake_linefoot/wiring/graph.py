"""The wiring of a diagram as plain data: its blocks, and what is connected to what."""

from __future__ import annotations

from dataclasses import dataclass

from pydrake.systems.framework import Diagram, InputPort, OutputPort, System


@dataclass(frozen=True)
class Port:
    """A port of a block, or an exported port of a diagram.

    Attributes:
        system: dotted path of the system below the root; empty for the root itself.
        name: of the port.
        is_input: whether it takes a signal, seen from outside the system.
    """

    system: str
    name: str
    is_input: bool

    def __str__(self) -> str:
        """Return `system.port`; ports of the root belong to `input` and `output`."""
        root = "input" if self.is_input else "output"
        return f"{self.system or root}.{self.name}"


@dataclass(frozen=True)
class Block:
    """A system without systems inside, or a diagram.

    Attributes:
        path: dotted path below the root; empty for the root itself.
        kind: name of its class.
        module: where the class is defined.
        inputs: its connected input ports, as declared; those of a diagram by name.
        outputs: the same of its output ports.
        blocks: the systems inside, when it is a diagram.
    """

    path: str
    kind: str
    module: str
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    blocks: tuple[Block, ...] = ()

    @property
    def name(self) -> str:
        """The last part of the path."""
        return self.path.rpartition(".")[2]


@dataclass(frozen=True)
class Wiring:
    """A whole diagram.

    Attributes:
        root: the diagram, with everything in it.
        connections: from, to; sorted by name.
    """

    root: Block
    connections: tuple[tuple[Port, Port], ...]


def read_wiring(diagram: Diagram) -> Wiring:
    """Return what is in a diagram, diagrams inside it expanded; unused ports are left out."""
    connections = sorted(_connections(diagram, ""), key=lambda pair: (str(pair[0]), str(pair[1])))
    used = {port for pair in connections for port in pair}
    return Wiring(_block(diagram, "", used), tuple(connections))


def _connections(diagram: Diagram, path: str) -> list[tuple[Port, Port]]:
    """Return the connections inside a diagram, and inside the diagrams it holds."""
    found = []
    for (target, target_index), (source, source_index) in diagram.connection_map().items():
        start = _output(source.get_output_port(source_index), _below(path, source))
        found.append((start, _input(target.get_input_port(target_index), _below(path, target))))
    for i in range(diagram.num_input_ports()):
        port = diagram.get_input_port(i)
        for system, index in diagram.GetInputPortLocators(port.get_index()):
            inner = _input(system.get_input_port(index), _below(path, system))
            found.append((_input(port, path), inner))
    for i in range(diagram.num_output_ports()):
        port = diagram.get_output_port(i)
        system, index = diagram.get_output_port_locator(port.get_index())
        inner = _output(system.get_output_port(index), _below(path, system))
        found.append((inner, _output(port, path)))
    for system in diagram.GetSystems():
        if isinstance(system, Diagram):
            found.extend(_connections(system, _below(path, system)))
    return found


def _block(system: System, path: str, used: set[Port]) -> Block:
    inputs = [_input(system.get_input_port(i), path) for i in range(system.num_input_ports())]
    outputs = [_output(system.get_output_port(i), path) for i in range(system.num_output_ports())]
    inside = []
    if isinstance(system, Diagram):
        inside = system.GetSystems()
        for ports in (inputs, outputs):  # in which order they were exported means nothing
            ports.sort(key=str)
    return Block(
        path=path,
        kind=type(system).__name__,
        module=type(system).__module__,
        inputs=tuple(port for port in inputs if port in used),
        outputs=tuple(port for port in outputs if port in used),
        blocks=tuple(_block(inner, _below(path, inner), used) for inner in inside),
    )


def _below(path: str, system: System) -> str:
    name = system.get_name()
    return f"{path}.{name}" if path else name


def _input(port: InputPort, path: str) -> Port:
    return Port(path, port.get_name(), is_input=True)


def _output(port: OutputPort, path: str) -> Port:
    return Port(path, port.get_name(), is_input=False)
