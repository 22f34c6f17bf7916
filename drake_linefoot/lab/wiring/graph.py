"""The wiring of a diagram as plain data: its blocks, and what is connected to what."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from pydrake.systems.framework import Diagram, InputPort, OutputPort, PortDataType, System


@dataclass(frozen=True)
class Port:
    """A port of a block, or an exported port of a diagram.

    Attributes:
        system: dotted path of the system below the root; empty for the root itself.
        name: of the port.
        is_input: whether it takes a signal, seen from outside the system.
        size: of a vector; None when it carries something else.
    """

    system: str
    name: str
    is_input: bool
    size: int | None

    def __str__(self) -> str:
        """Return `system.port`; ports of the root belong to `input` and `output`."""
        root = "input" if self.is_input else "output"
        return f"{self.system or root}.{self.name}"


Connection = tuple[Port, Port]  # from, to


@dataclass(frozen=True)
class Block:
    """A system without systems inside, or a diagram.

    Attributes:
        path: dotted path below the root; empty for the root itself.
        system: itself.
        inputs: its input ports, as declared, those of a diagram by name; inside a diagram
            only those that are connected.
        outputs: the same of its output ports.
        blocks: the systems inside, when it is a diagram.
        connections: of the root of a diagram: from, to; sorted by name.
    """

    path: str
    system: System
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    blocks: tuple[Block, ...] = ()
    connections: tuple[Connection, ...] = ()

    @property
    def name(self) -> str:
        """The last part of the path."""
        return self.path.rpartition(".")[2]

    @property
    def kind(self) -> type:
        """Its class."""
        return type(self.system)


def read_wiring(system: System) -> Block:
    """Return what is in a diagram, diagrams inside it expanded; unused ports are left out.

    Any other system is returned alone, with all its ports.
    """
    if not isinstance(system, Diagram):
        alone = _block(system, system.get_name(), None)
        return Block("", system, (), (), (alone,))
    connections = sorted(_connections(system, ""), key=lambda pair: (str(pair[0]), str(pair[1])))
    return replace(_block(system, "", connections), connections=tuple(connections))


def all_blocks(block: Block) -> Iterator[Block]:
    """Yield the blocks inside a block, each followed by what is inside it."""
    for inner in block.blocks:
        yield inner
        yield from all_blocks(inner)


def _connections(diagram: Diagram, path: str) -> list[Connection]:
    """Return the connections inside a diagram, and inside the diagrams it holds."""
    found = []
    for (target, target_index), (source, source_index) in diagram.connection_map().items():
        start = _port(source.get_output_port(source_index), _below(path, source))
        found.append((start, _port(target.get_input_port(target_index), _below(path, target))))
    for i in range(diagram.num_input_ports()):
        port = diagram.get_input_port(i)
        for system, index in diagram.GetInputPortLocators(port.get_index()):
            inner = _port(system.get_input_port(index), _below(path, system))
            found.append((_port(port, path), inner))
    for i in range(diagram.num_output_ports()):
        port = diagram.get_output_port(i)
        system, index = diagram.get_output_port_locator(port.get_index())
        inner = _port(system.get_output_port(index), _below(path, system))
        found.append((inner, _port(port, path)))
    for system in diagram.GetSystems():
        if isinstance(system, Diagram):
            found.extend(_connections(system, _below(path, system)))
    return found


def _block(system: System, path: str, connections: list[Connection] | None) -> Block:
    """Return a system; only the ports in `connections` count when they are given."""
    inputs = [_port(system.get_input_port(i), path) for i in range(system.num_input_ports())]
    outputs = [_port(system.get_output_port(i), path) for i in range(system.num_output_ports())]
    inside = []
    if isinstance(system, Diagram):
        inside = system.GetSystems()
        for ports in (inputs, outputs):  # in which order they were exported means nothing
            ports.sort(key=str)
    if connections is not None:
        used = {port for pair in connections for port in pair}
        inputs, outputs = ([port for port in ports if port in used] for ports in (inputs, outputs))
    blocks = [_block(inner, _below(path, inner), connections) for inner in inside]
    return Block(
        path=path,
        system=system,
        inputs=tuple(inputs),
        outputs=tuple(outputs),
        blocks=tuple(blocks),
    )


def _below(path: str, system: System) -> str:
    name = system.get_name()
    return f"{path}.{name}" if path else name


def _port(port: InputPort | OutputPort, path: str) -> Port:
    size = port.size() if port.get_data_type() == PortDataType.kVectorValued else None
    return Port(path, port.get_name(), isinstance(port, InputPort), size)
