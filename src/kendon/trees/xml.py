"""Reader and writer of BehaviorTree.CPP's XML, the files Groot and Groot2 open.

Read are versions 3 and 4, written is version 4. Reading answers a `TreeLibrary` that has passed
all checks; ``write(read(file))`` written and read again is the same. Comments are not kept, and
included files become part of the one that is written.
"""

from __future__ import annotations

from pathlib import Path
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

from kendon.errors import TreeError
from kendon.outputs import write_text
from kendon.trees import nodes as _nodes  # noqa: F401  fills the registry
from kendon.trees.library import NodeSpec, TreeLibrary, check
from kendon.trees.ports import PORT_TYPES, key_of
from kendon.trees.registry import NODES, Category

#: What version 3 calls otherwise: nodes, and ports by node.
V3_NODES = {
    "SequenceStar": "SequenceWithMemory",
    "RetryUntilSuccesful": "RetryUntilSuccessful",
    "SubTreePlus": "SubTree",
}
V3_PORTS = {
    "Parallel": {
        "success_threshold": "success_count",
        "failure_threshold": "failure_count",
        "threshold": "success_count",
    }
}
_V3_SUBTREE_SHARING = ("__autoremap", "__shared_blackboard")

_EXPLICIT = ("Action", "Condition", "Control", "Decorator")


class _Element:
    """An XML element with the line it starts at."""

    def __init__(self, tag: str, attributes: dict[str, str], line: int) -> None:
        self.tag, self.attributes, self.line = tag, attributes, line
        self.children: list[_Element] = []


def _parse_elements(text: str | bytes, source: str) -> _Element:
    parser = expat.ParserCreate()
    stack = [_Element("", {}, 0)]

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = _Element(tag, attributes, parser.CurrentLineNumber)
        stack[-1].children.append(element)
        stack.append(element)

    def end(tag: str) -> None:
        stack.pop()

    def doctype(*_: object) -> None:
        # Entities can make a few lines expand without bound.
        line = parser.CurrentLineNumber
        raise TreeError(f"{source} line {line}: a document type declaration is not allowed")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        raise TreeError(
            f"{source} line {error.lineno}: this is not well-formed XML: {reason}"
        ) from None
    return stack[0].children[0]


class _Reader:
    """Collects the trees of one file and those it includes."""

    def __init__(self) -> None:
        self.trees: dict[str, NodeSpec] = {}
        self.seen: set[Path] = set()

    def read_file(self, path: Path, place: str) -> str | None:
        """Read one file; returns the main tree it names."""
        self.seen.add(path.resolve())
        try:
            data = path.read_bytes()
        except OSError as error:
            raise TreeError(
                f"{place}the tree file cannot be read: {error.strerror or error}"
            ) from None
        return self.read(data, str(path), path.parent)

    def read(self, text: str | bytes, source: str, folder: Path) -> str | None:
        root = _parse_elements(text, source)
        if root.tag != "root":
            raise TreeError(
                f"{source} line {root.line}: a tree file begins with <root>, not <{root.tag}>"
            )
        version = root.attributes.get("BTCPP_format", "3")
        if version not in ("3", "4"):
            raise TreeError(
                f"{source} line {root.line}: BTCPP_format {version!r} is unknown; valid: 3, 4"
            )
        for element in root.children:
            place = f"{source} line {element.line}"
            if element.tag == "BehaviorTree":
                self._add_tree(element, source, version == "3")
            elif element.tag == "include":
                self._include(element, place, folder)
            elif element.tag != "TreeNodesModel":
                raise TreeError(
                    f"{place}: <root> holds BehaviorTree, TreeNodesModel and include,"
                    f" not {element.tag}"
                )
        return root.attributes.get("main_tree_to_execute")

    def _include(self, element: _Element, place: str, folder: Path) -> None:
        path = element.attributes.get("path")
        if path is None or "ros_pkg" in element.attributes:
            raise TreeError(
                f"{place}: an include needs the attribute path, a file relative to this one"
            )
        target = folder / path
        if target.resolve() not in self.seen:
            self.read_file(target, f"{place}: {path}: ")

    def _add_tree(self, element: _Element, source: str, v3: bool) -> None:
        place = f"{source} line {element.line}"
        name = element.attributes.get("ID")
        if not name:
            raise TreeError(f"{place}: a BehaviorTree needs the attribute ID")
        if name in self.trees:
            raise TreeError(f"{place}: there are two trees with the ID {name!r}")
        if len(element.children) != 1:
            raise TreeError(
                f"{place}: tree {name!r} needs exactly one node at its top,"
                f" not {len(element.children)}"
            )
        self.trees[name] = _node(element.children[0], v3, f"{source} line {{}}, tree {name!r}")


def _node(element: _Element, v3: bool, place: str) -> NodeSpec:
    where = place.format(element.line)
    attributes = dict(element.attributes)
    kind = element.tag
    if kind in _EXPLICIT:
        category = kind
        if "ID" not in attributes:
            raise TreeError(f"{where}: <{category}> needs the attribute ID, the node's type")
        kind = attributes.pop("ID")
        known = NODES.get(V3_NODES.get(kind, kind) if v3 else kind)
        if known is not None and known.category != category:
            raise TreeError(
                f"{where}, node {kind}: it is of class {known.category}, not {category}"
            )
    if not v3 and kind in V3_NODES:
        raise TreeError(f"{where}, node {kind}: version 4 calls it {V3_NODES[kind]}")
    name = attributes.pop("name", "")
    if v3:
        kind, attributes = _from_v3(kind, attributes)
    children = [_node(child, v3, place) for child in element.children]
    return NodeSpec(kind, name, attributes, children, element.line)


def _from_v3(kind: str, attributes: dict[str, str]) -> tuple[str, dict[str, str]]:
    plus = kind == "SubTreePlus"
    kind = V3_NODES.get(kind, kind)
    renamed = V3_PORTS.get(kind, {})
    attributes = {renamed.get(name, name): text for name, text in attributes.items()}
    if kind == "SubTree":
        shared = [attributes.pop(name, "") for name in _V3_SUBTREE_SHARING]
        if not plus:  # version 3's plain SubTree writes the outer key without braces
            attributes = {
                name: text if name == "ID" or key_of(text) else f"{{{text}}}"
                for name, text in attributes.items()
            }
        if any(text.strip().lower() in ("true", "1") for text in shared):
            attributes["_autoremap"] = "true"
    return kind, attributes


def read_trees(path: str | Path) -> TreeLibrary:
    """Read a BehaviorTree.CPP XML file, version 3 or 4, and the files it includes.

    Raises:
        TreeError: the file cannot be read, is not well-formed, or does not make sense; the
            sentence names file, line, tree, node and what would be valid.
    """
    file, reader = Path(path), _Reader()
    main = reader.read_file(file, f"{path}: ")
    return _finish(reader, main, str(path))


def parse_trees(text: str, source: str = "<text>", folder: str | Path = ".") -> TreeLibrary:
    """Read BehaviorTree.CPP XML from a text; includes are looked for in `folder`.

    Raises:
        TreeError: as `read_trees`.

    >>> text = '<root BTCPP_format="4"><BehaviorTree ID="A"><AlwaysSuccess/></BehaviorTree></root>'
    >>> parse_trees(text).main
    'A'
    """
    reader = _Reader()
    main = reader.read(text, source, Path(folder))
    return _finish(reader, main, source)


def _finish(reader: _Reader, main: str | None, source: str) -> TreeLibrary:
    if main is None:
        if len(reader.trees) != 1:
            ids = ", ".join(reader.trees) or "none"
            raise TreeError(
                f"{source}: the root does not say main_tree_to_execute, and the file holds"
                f" {len(reader.trees)} trees: {ids}"
            )
        (main,) = reader.trees
    library = TreeLibrary(main, reader.trees, source)
    check(library)
    return library


def format_trees(library: TreeLibrary) -> str:
    """The library as BehaviorTree.CPP XML of version 4, with the models Groot2 needs.

    Raises:
        TreeError: the library does not pass `check`.
    """
    check(library)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<root BTCPP_format="4" main_tree_to_execute={quoteattr(library.main)}>',
    ]
    for tree, root in library.trees.items():
        lines.append(f"  <BehaviorTree ID={quoteattr(tree)}>")
        lines.extend(_format_node(root, "    "))
        lines.append("  </BehaviorTree>")
    used = {node.kind for root in library.trees.values() for node in root.walk()}
    lines.extend(format_model(used))
    lines.append("</root>")
    return "\n".join(lines) + "\n"


def write_trees(library: TreeLibrary, path: str | Path) -> None:
    """Write the library to a file as `format_trees` formats it.

    Raises:
        TreeError: the library does not pass `check`.
        DataError: the file cannot be written.
    """
    text = format_trees(library)
    write_text(path, text)


def _format_node(node: NodeSpec, indent: str) -> list[str]:
    attributes = dict(node.attributes)
    head = {"ID": attributes.pop("ID")} if node.subtree else {}
    if node.name != (head["ID"] if node.subtree else node.kind):
        head["name"] = node.name
    shown = "".join(f" {k}={quoteattr(v)}" for k, v in {**head, **attributes}.items())
    if not node.children:
        return [f"{indent}<{node.kind}{shown}/>"]
    inner = [line for child in node.children for line in _format_node(child, indent + "  ")]
    return [f"{indent}<{node.kind}{shown}>", *inner, f"{indent}</{node.kind}>"]


def format_model(kinds: set[str]) -> list[str]:
    """The lines of ``TreeNodesModel`` for those node types Groot2 does not know by itself."""
    lines = ["  <TreeNodesModel>"]
    for name in sorted(kinds):
        node = NODES.get(name)
        if node is None or node.builtin:
            continue
        category: Category = node.category
        lines.append(f"    <{category} ID={quoteattr(name)}>")
        for port in node.ports:
            default = "" if port.default is None else f" default={quoteattr(port.default)}"
            cpp = quoteattr(PORT_TYPES[port.type].cpp)
            tag = f"{port.direction}_port"
            lines.append(
                f"      <{tag} name={quoteattr(port.name)} type={cpp}{default}>"
                f"{escape(port.doc)}</{tag}>"
            )
        lines.append(f"    </{category}>")
    lines.append("  </TreeNodesModel>")
    return lines
