"""Belief to commands: behaviour trees in BehaviorTree.CPP's XML, run by py_trees.

    tree = GreetingTree()                    # or GreetingTree("my_trees.xml")
    tree.tick(TickContext(t, belief.phase, person, robot))   # ten times a second
    tree.states()                            # every node, for display

Own node types enter with `register_node`.
"""

from kendon.trees.leaves import Leaf
from kendon.trees.library import NodeSpec, TreeLibrary
from kendon.trees.ports import BoundPorts, Port
from kendon.trees.poses import Pose
from kendon.trees.registry import NODES, NodeType, register_node
from kendon.trees.state import TickContext, TreeState
from kendon.trees.tree import TICK_RATE, GreetingTree, NodeState, shipped_trees
from kendon.trees.xml import format_trees, parse_trees, read_trees, write_trees

__all__ = [
    "NODES",
    "TICK_RATE",
    "BoundPorts",
    "GreetingTree",
    "Leaf",
    "NodeSpec",
    "NodeState",
    "NodeType",
    "Port",
    "Pose",
    "TickContext",
    "TreeLibrary",
    "TreeState",
    "format_trees",
    "parse_trees",
    "read_trees",
    "register_node",
    "shipped_trees",
    "write_trees",
]
