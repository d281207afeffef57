"""The one table of node types: what trees may be built of, with their ports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from py_trees.behaviour import Behaviour

from kendon.errors import TreeError, UnknownNameError
from kendon.trees.ports import PORT_TYPES, BoundPorts, Port
from kendon.trees.state import TreeState

Category = Literal["Action", "Condition", "Control", "Decorator"]

#: Makes one node: its name, its bound ports, the tree's shared state, its children.
Factory = Callable[[str, BoundPorts, TreeState, Sequence[Behaviour]], Behaviour]


@dataclass(frozen=True)
class NodeType:
    """One type of node.

    Args:
        id: its name in the XML.
        category: BehaviorTree.CPP's class of nodes; leaves are Action and Condition.
        factory: makes a node of it.
        ports: what it reads and writes.
        doc: one sentence for people.
        children: the smallest and the largest number of children; None for any number.
        builtin: whether BehaviorTree.CPP has it itself, so that Groot needs no model of it.
    """

    id: str
    category: Category
    factory: Factory
    ports: tuple[Port, ...] = ()
    doc: str = ""
    children: tuple[int, int | None] = (0, 0)
    builtin: bool = False


#: Every node type by its name; extend it with `register_node`.
NODES: dict[str, NodeType] = {}

#: Names with a meaning of their own in the XML.
RESERVED = ("SubTree", "SubTreePlus", "BehaviorTree", "TreeNodesModel", "root", "include")


def register_node(node: NodeType) -> NodeType:
    """Add a node type, so that XML files may use it and errors list it.

    Raises:
        TreeError: the name is taken, or a port's type or default makes no sense.
    """
    if node.id in NODES or node.id in RESERVED:
        raise TreeError(f"there is a tree node {node.id!r} already")
    for port in node.ports:
        if port.type not in PORT_TYPES:
            raise TreeError(
                f"tree node {node.id!r}, port {port.name!r}:"
                f" {UnknownNameError('port type', port.type, PORT_TYPES)}"
            )
    NODES[node.id] = node
    return node


def node_type(name: str) -> NodeType:
    """The node type of a name.

    Raises:
        UnknownNameError: there is none.
    """
    try:
        return NODES[name]
    except KeyError:
        raise UnknownNameError("tree node", name, sorted([*NODES, "SubTree"])) from None
