"""A set of behaviour trees as plain data, and the checks it must pass before it is built."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from kendon.errors import TreeError, UnknownNameError
from kendon.trees.control import threshold
from kendon.trees.ports import Output, Port, Scope, key_of
from kendon.trees.registry import NODES, NodeType, node_type

#: Attributes Groot and BehaviorTree.CPP write for people; they change nothing.
REMARKS = ("_description", "_fullpath", "_uid", "_autoremap")

#: BehaviorTree.CPP's scripting attributes. kendon runs no scripts; leaving one out in silence
#: would change what the tree does.
SCRIPTS = (
    "_skipIf",
    "_successIf",
    "_failureIf",
    "_while",
    "_onSuccess",
    "_onFailure",
    "_onHalted",
    "_post",
)


@dataclass
class NodeSpec:
    """One node as written in the XML.

    Args:
        kind: the node type's name; "SubTree" for a reference to another tree.
        name: the node's own name, the kind (a SubTree's: the tree's id) if none was given.
        attributes: the ports' texts; a SubTree's ``ID`` and remapped keys; remarks.
        children: from left to right.
        line: in the file, 0 if it comes from no file; equality ignores it.
    """

    kind: str
    name: str = ""
    attributes: dict[str, str] = field(default_factory=dict)
    children: list[NodeSpec] = field(default_factory=list)
    line: int = field(default=0, compare=False)

    def __post_init__(self) -> None:
        if not self.name:
            self.name = self.attributes.get("ID", self.kind) if self.subtree else self.kind

    @property
    def subtree(self) -> bool:
        """Whether the node stands for another tree."""
        return self.kind == "SubTree"

    def walk(self) -> Iterator[NodeSpec]:
        """This node and all below it, parents first."""
        yield self
        for child in self.children:
            yield from child.walk()


@dataclass
class TreeLibrary:
    """Trees that belong together.

    Args:
        main: the id of the tree that is run.
        trees: every tree's root node by the tree's id.
        source: where they come from, for messages; equality ignores it.
    """

    main: str
    trees: dict[str, NodeSpec]
    source: str = field(default="<trees>", compare=False)

    def place(self, tree: str, node: NodeSpec) -> str:
        """Where a node stands, as errors begin: file, line, tree, node."""
        line = f" line {node.line}" if node.line else ""
        called = "" if node.name == node.kind else f" {node.name!r}"
        return f"{self.source}{line}, tree {tree!r}, node {node.kind}{called}"


def check(library: TreeLibrary) -> None:
    """Make sure that a library can be built and ticked.

    Raises:
        TreeError: it cannot; the sentence names file, line, tree, node and what would be valid.
    """
    if library.main not in library.trees:
        raise TreeError(
            f"{library.source}: the main tree does not exist:"
            f" {UnknownNameError('tree', library.main, library.trees)}"
        )
    for tree, root in library.trees.items():
        for node in root.walk():
            try:
                _check_node(node, library)
            except (TreeError, UnknownNameError) as error:
                raise TreeError(f"{library.place(tree, node)}: {error}") from None
    _check_recursion(library, library.main, [])
    for tree in library.trees:
        _check_recursion(library, tree, [])


def _check_node(node: NodeSpec, library: TreeLibrary) -> None:
    for name in SCRIPTS:
        if node.attributes.get(name):
            raise TreeError(f"the script {name!r} cannot be run; kendon's trees take no scripts")
    if node.subtree:
        target = node.attributes.get("ID")
        if target is None:
            raise TreeError("a SubTree needs the attribute ID, the id of a tree")
        if target not in library.trees:
            raise UnknownNameError("tree", target, library.trees)
        if node.children:
            raise TreeError("a SubTree has no children of its own")
        return
    if node.kind not in NODES and node.kind in library.trees:
        raise TreeError(f'this is a tree, written <SubTree ID="{node.kind}"/>')
    kind = node_type(node.kind)
    _check_children(node, kind)
    _check_ports(node, kind)


def _check_children(node: NodeSpec, kind: NodeType) -> None:
    fewest, most = kind.children
    count = len(node.children)
    if fewest <= count and (most is None or count <= most):
        return
    if most is None:
        needed = f"at least {fewest}"
    elif node.kind.startswith("Switch"):
        needed = f"{most} ({most - 1} cases and the default)"
    else:
        needed = str(most) if most else "no"
    noun = "child" if needed == "1" or needed == "at least 1" else "children"
    raise TreeError(f"it needs {needed} {noun}, not {count}")


def _check_ports(node: NodeSpec, kind: NodeType) -> None:
    ports = {port.name: port for port in kind.ports}
    for name in node.attributes:
        if name not in ports and name not in REMARKS and name not in SCRIPTS:
            raise UnknownNameError("port", name, ports)
    for port in kind.ports:
        text = node.attributes.get(port.name, port.default)
        if text is None:
            have = ", ".join(f"{p.name} ({p.direction})" for p in kind.ports)
            raise TreeError(f"the required port {port.name!r} is missing; its ports: {have}")
        _check_text(port, text)
    if node.kind == "Parallel":
        for name in ("success_count", "failure_count"):
            text = node.attributes.get(name)
            if text is not None and key_of(text) is None:
                threshold(int(text), len(node.children))


def _check_text(port: Port, text: str) -> None:
    if port.direction != "input":
        Output(port, text, Scope())
    elif key_of(text) is None:
        port.parse(text)


def _check_recursion(library: TreeLibrary, tree: str, above: list[str]) -> None:
    if tree in above:
        chain = " -> ".join([*above[above.index(tree) :], tree])
        raise TreeError(f"{library.source}: the trees contain each other: {chain}")
    for node in library.trees[tree].walk():
        if node.subtree:
            _check_recursion(library, node.attributes["ID"], [*above, tree])
