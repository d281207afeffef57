"""Ports and blackboards: how nodes of one tree instance pass values to each other.

py_trees's own blackboard is one dictionary for the whole process, reached by composed names
through access checks. Two trees in one process would share it, and each read costs microseconds.
Here every tree instance owns its scopes, one for each SubTree as in BehaviorTree.CPP, and a port
is bound to its entry once, when the tree is built: a read is then one attribute access.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from kendon.errors import TreeError
from kendon.trees.poses import FRAMES, Pose, parse_pose

Direction = Literal["input", "output", "inout"]

#: Vizzy's arm routines, in the order of the numbers its arm topic takes.
_VIZZYS = (
    "HOME",
    "WAVE",
    "STRETCH",
    "HANDSHAKE",
    "ASK_HANDSHAKE",
    "HANDSHAKE_PID",
    "ARMS_DOWN",
    "HAPPY_EMOTIONLESS",
    "HAPPY_EMOTIVE",
    "SAD",
    "ANGRY",
    "FEAR",
)
#: Gestures that kendon's own body performs besides (see `kendon.robots.mujoco`).
_KENDONS = ("NOD", "HEAD_DIP", "BODY_CROSS", "GROOMING")
#: All gestures a tree may name, with kendon's names for them; a robot with gestures of its own
#: adds them above.
GESTURES: dict[str, str] = {name: name.lower() for name in (*_VIZZYS, *_KENDONS)}
GESTURE_NUMBERS: dict[str, str] = {str(i): name.lower() for i, name in enumerate(_VIZZYS)}


def _parse_number(text: str) -> float:
    number = float(text)
    if math.isnan(number):
        raise ValueError(text)
    return number


def _parse_bool(text: str) -> bool:
    return {"true": True, "1": True, "false": False, "0": False}[text.strip().lower()]


def _parse_gesture(text: str) -> str:
    wanted = text.strip()
    return GESTURE_NUMBERS.get(wanted) or GESTURES[wanted.upper()]


def _parse_frame(text: str) -> str:
    frame = text.strip().removeprefix("/")
    if frame and frame not in FRAMES:
        raise ValueError(text)
    return frame


@dataclass(frozen=True)
class PortType:
    """How a port's text becomes a value.

    Args:
        parse: text to value; raises ValueError or KeyError for a text it cannot read.
        values: the Python types a blackboard entry may already have.
        wanted: what the port needs, for the error's sentence.
        cpp: the type's name in BehaviorTree.CPP's ``TreeNodesModel``.
    """

    parse: Callable[[str], Any]
    values: tuple[type, ...]
    wanted: str
    cpp: str


PORT_TYPES: dict[str, PortType] = {
    "string": PortType(str, (str,), "a text", "std::string"),
    "double": PortType(_parse_number, (float, int), "a number", "double"),
    "int": PortType(int, (int,), "a whole number", "int"),
    "bool": PortType(_parse_bool, (bool,), "true or false", "bool"),
    "pose": PortType(
        parse_pose, (Pose,), "a pose as x;y;z or x;y;z;qx;qy;qz;qw", "geometry_msgs::PoseStamped"
    ),
    "frame": PortType(_parse_frame, (), f"one of {', '.join(FRAMES)}", "std::string"),
    "gesture": PortType(
        _parse_gesture, (), f"one of {', '.join(GESTURES)} or its number", "std::string"
    ),
    "any": PortType(lambda text: text, (object,), "a value", "BT::AnyTypeAllowed"),
}


@dataclass(frozen=True)
class Port:
    """One port of a node type.

    Args:
        name: as written in the XML.
        direction: whether the node reads it, writes it or both.
        type: a name of `PORT_TYPES`.
        default: the text used when the XML leaves the port out; None makes it required.
        doc: one sentence for Groot, with the unit.
        minimum: the smallest number allowed, None for any.
        maximum: the largest number allowed, None for any.
        choices: the only texts allowed, empty for any.
        bare_key: an output port may name its key without braces, as SetBlackboard's does.
    """

    name: str
    direction: Direction = "input"
    type: str = "string"
    default: str | None = None
    doc: str = ""
    minimum: float | None = None
    maximum: float | None = None
    choices: tuple[str, ...] = ()
    bare_key: bool = False

    def parse(self, text: str) -> Any:
        """The value of a text written at this port.

        Raises:
            TreeError: the text is not of the port's type, range or choices.
        """
        kind = PORT_TYPES[self.type]
        try:
            value = kind.parse(text)
        except (ValueError, KeyError):
            raise TreeError(f"port {self.name!r} needs {kind.wanted}, not {text!r}") from None
        return self.checked(value)

    def checked(self, value: Any) -> Any:
        """The same value, if it lies in the port's range.

        Raises:
            TreeError: it does not.
        """
        if self.choices and value not in self.choices:
            valid = ", ".join(self.choices)
            raise TreeError(f"port {self.name!r} takes {valid}, not {value!r}")
        if self.minimum is not None and value < self.minimum:
            raise TreeError(f"port {self.name!r} is at least {self.minimum:g}, not {value:g}")
        if self.maximum is not None and value > self.maximum:
            raise TreeError(f"port {self.name!r} is at most {self.maximum:g}, not {value:g}")
        return value


def key_of(text: str, port_name: str = "") -> str | None:
    """The blackboard key of ``{key}``; None for a plain text. ``{=}`` is the port's own name.

    >>> key_of("{closest_face}"), key_of("WAVE")
    ('closest_face', None)
    """
    stripped = text.strip()
    if len(stripped) > 2 and stripped[0] == "{" and stripped[-1] == "}":
        key = stripped[1:-1].strip()
        return port_name if key == "=" else key
    return None


class _Unset:
    def __repr__(self) -> str:
        return "unset"


UNSET = _Unset()


class Entry:
    """One value on a blackboard."""

    __slots__ = ("value",)

    def __init__(self, value: Any = UNSET) -> None:
        self.value = value


class Scope:
    """The blackboard of one tree or subtree (BehaviorTree.CPP: each SubTree has its own).

    Args:
        parent: the scope of the tree that holds the SubTree node; None for the main tree.
        remap: the SubTree's attributes: ``key="{outer}"`` shares an entry of the parent,
            ``key="text"`` puts a text on this blackboard.
        autoremap: share every other key with the parent's of the same name, except those that
            begin with an underscore.
    """

    def __init__(
        self,
        parent: Scope | None = None,
        remap: Mapping[str, str] | None = None,
        autoremap: bool = False,
    ) -> None:
        self._parent = parent
        self._remap = dict(remap or {})
        self._autoremap = autoremap
        self._entries: dict[str, Entry] = {}

    def entry(self, key: str) -> Entry:
        """The entry of a key, made when it is new; ``@key`` means the main tree's."""
        if key.startswith("@"):
            scope = self
            while scope._parent is not None:
                scope = scope._parent
            return scope.entry(key[1:])
        found = self._entries.get(key)
        if found is None:
            found = self._entries[key] = self._resolve(key)
        return found

    def _resolve(self, key: str) -> Entry:
        if self._parent is not None:
            text = self._remap.get(key)
            if text is not None:
                outer = key_of(text, key)
                return Entry(text) if outer is None else self._parent.entry(outer)
            if self._autoremap and not key.startswith("_"):
                return self._parent.entry(key)
        return Entry()

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        return ((k, e.value) for k, e in self._entries.items() if e.value is not UNSET)


class Input:
    """An input port of one node, bound to a constant or to a blackboard entry."""

    __slots__ = ("_constant", "_entry", "_key", "_port", "_values")

    def __init__(self, port: Port, text: str, scope: Scope) -> None:
        self._port = port
        self._key = key_of(text, port.name)
        self._entry = None if self._key is None else scope.entry(self._key)
        self._constant = port.parse(text) if self._key is None else None
        self._values = PORT_TYPES[port.type].values

    def get(self) -> Any:
        """The port's value, converted to its type.

        Raises:
            TreeError: no node has written the entry yet, or its value does not fit the port.
        """
        if self._entry is None:
            return self._constant
        value = self._entry.value
        if value is UNSET:
            raise TreeError(
                f"port {self._port.name!r} reads {{{self._key}}}, which no node has written yet"
            )
        if isinstance(value, self._values):
            return self._port.checked(value)
        if isinstance(value, str):
            return self._port.parse(value)
        if self._port.type == "string":
            return str(value)
        raise TreeError(
            f"port {self._port.name!r} needs {PORT_TYPES[self._port.type].wanted},"
            f" but {{{self._key}}} holds {value!r}"
        )


class Output:
    """An output port of one node, bound to a blackboard entry."""

    __slots__ = ("_entry",)

    def __init__(self, port: Port, text: str, scope: Scope) -> None:
        key = key_of(text, port.name)
        if key is None:
            if not port.bare_key or not text.strip():
                raise TreeError(
                    f"port {port.name!r} is an output and needs a blackboard key in braces,"
                    f" like {{{port.name}}}, not {text!r}"
                )
            key = text.strip()
        self._entry = scope.entry(key)

    def set(self, value: Any) -> None:
        """Write the port's value."""
        self._entry.value = value


class BoundPorts:
    """All ports of one node of one tree instance, bound to its blackboard.

    Raises:
        TreeError: a port is missing, or its text does not fit.
    """

    def __init__(self, ports: tuple[Port, ...], texts: Mapping[str, str], scope: Scope) -> None:
        self._inputs: dict[str, Input] = {}
        self._outputs: dict[str, Output] = {}
        for port in ports:
            text = texts.get(port.name, port.default)
            if text is None:
                raise TreeError(f"the required port {port.name!r} is missing")
            if port.direction != "output":
                self._inputs[port.name] = Input(port, text, scope)
            if port.direction != "input":
                self._outputs[port.name] = Output(port, text, scope)

    def input(self, name: str) -> Input:
        """The input port of a name."""
        return self._inputs[name]

    def output(self, name: str) -> Output:
        """The output port of a name."""
        return self._outputs[name]
