"""A behaviour tree that answers a greeting: built from XML, ticked ten times a second."""

from __future__ import annotations

import functools
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from kendon.errors import TreeError, UnknownNameError
from kendon.phases import Phase
from kendon.robots.base import Robot
from kendon.trees.decorators import SubTree
from kendon.trees.library import NodeSpec, TreeLibrary, check
from kendon.trees.ports import BoundPorts, Scope, key_of
from kendon.trees.registry import node_type
from kendon.trees.state import TickContext, TreeState
from kendon.trees.xml import parse_trees, read_trees

#: Ticks of the tree a second (thesis 4.1.1): twice the rate of the beliefs.
TICK_RATE = 10.0

_SHOWN = {
    Status.INVALID: "idle",
    Status.RUNNING: "running",
    Status.SUCCESS: "success",
    Status.FAILURE: "failure",
}


class NodeState(NamedTuple):
    """One node as it stands after the last tick, for display."""

    path: str  # names from the main tree down, joined by "/"; unique in the tree
    kind: str  # the node type: "MoveBase", "Sequence", "SubTree"
    name: str
    status: str  # "idle", "running", "success" or "failure"
    message: str  # why it failed, or nothing


@functools.cache
def shipped_trees() -> TreeLibrary:
    """The trees that come with kendon: figures 4.2-4.10 of the thesis."""
    text = files("kendon.trees").joinpath("greeting.xml").read_text(encoding="utf-8")
    library = parse_trees(text, "greeting.xml")
    check(library)
    return library


class GreetingTree:
    """One running instance of a behaviour tree.

    Instances share nothing: each owns its nodes, its blackboards and its memory.

    Args:
        source: a BehaviorTree.CPP XML file, a library, or None for the shipped greeting.
        main: the id of the tree to run, if it is not the library's main tree.

    Raises:
        TreeError: the trees cannot be read or do not make sense.
        UnknownNameError: there is no tree `main`.
    """

    def __init__(
        self, source: str | Path | TreeLibrary | None = None, *, main: str | None = None
    ) -> None:
        if source is None:
            library = shipped_trees()  # checked when it was read
        else:
            library = source if isinstance(source, TreeLibrary) else read_trees(source)
            check(library)
        if main is not None and main not in library.trees:
            raise UnknownNameError("tree", main, library.trees)
        self.library = library
        self._state = TreeState()
        self._scope = Scope()
        self._nodes: list[tuple[str, str, Behaviour]] = []
        self._paths: set[str] = set()
        self._asking: list[tuple[str, NodeSpec]] = []  # the nodes that ask for something by name
        tree = main or library.main
        self.root = self._build(library.trees[tree], tree, self._scope, tree)

    def tick(self, context: TickContext) -> Status:
        """Tick the tree once: about 0.1 ms. Never blocks, never raises for a robot's failure.

        Returns:
            The status of the main tree's top node.
        """
        self._state.update(context)
        self.root.tick_once()
        return self.root.status

    def halt(self) -> None:
        """Halt every node, cancel every command that still runs, and forget the person."""
        self.root.stop(Status.INVALID)
        self._state.forget()

    def require(self, robot: Robot) -> None:
        """Refuse a robot that has not the gestures and faces that the tree's nodes name.

        A name on the blackboard shows only in ticking; and a robot without a face that moves does
        without the expressions that every robot may be asked for (`kendon.robots.Robot`).

        Raises:
            TreeError: the sentence names file, line, tree, node and the robot's own.
        """
        faces = {*robot.expressions, *Robot.expressions}
        for port, what, known in (
            ("gesture", "gesture", robot.gestures), ("expression", "expression", sorted(faces)),
        ):  # fmt: skip
            for tree, spec in self._asking:
                text = spec.attributes.get(port)
                if text is None or key_of(text) is not None:
                    continue
                [read] = [p for p in node_type(spec.kind).ports if p.name == port]
                if read.parse(text) not in known:
                    raise TreeError(
                        f"{self.library.place(tree, spec)}: the robot has no {what} {text!r};"
                        f" it has {', '.join(known)}"
                    )

    @property
    def active_phase(self) -> Phase | None:
        """The phase of the last tick; None before the first, without a belief, after `halt`."""
        return self._state.phase

    @property
    def blackboard(self) -> dict[str, Any]:
        """The written entries of the main tree's blackboard."""
        return dict(self._scope)

    def states(self) -> list[NodeState]:
        """Every node as it stands after the last tick, parents before their children."""
        return [
            NodeState(path, kind, node.name, shown, "" if shown == "idle" else message)
            for path, kind, node in self._nodes
            for shown, message in [(_SHOWN[node.status], node.feedback_message)]
        ]

    def _build(self, spec: NodeSpec, tree: str, scope: Scope, above: str) -> Behaviour:
        path = self._path(above, spec.name)
        place = len(self._nodes)
        if spec.subtree:
            target = spec.attributes["ID"]
            remap = {k: v for k, v in spec.attributes.items() if k != "ID" and k[0] != "_"}
            auto = spec.attributes.get("_autoremap", "").lower() in ("true", "1")
            inner = Scope(scope, remap, auto)
            child = self._build(self.library.trees[target], target, inner, path)
            node: Behaviour = SubTree(name=spec.name, child=child)
        else:
            children = [self._build(child, tree, scope, path) for child in spec.children]
            kind = node_type(spec.kind)
            if spec.kind in ("ArmRoutines", "Express"):
                self._asking.append((tree, spec))
            try:
                ports = BoundPorts(kind.ports, spec.attributes, scope)
                node = kind.factory(spec.name, ports, self._state, children)
            except TreeError as error:
                raise TreeError(f"{self.library.place(tree, spec)}: {error}") from None
        self._nodes.insert(place, (path, spec.kind, node))
        return node

    def _path(self, above: str, name: str) -> str:
        """Where a node is: each path once."""
        path, count = f"{above}/{name}", 1
        while path in self._paths:
            count += 1
            path = f"{above}/{name}[{count}]"
        self._paths.add(path)
        return path
