"""What a user may say of kendon's node, on the command line or by parameters of ROS."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from enum import Enum
from typing import Any

from kendon.errors import ParameterError, UnknownNameError
from kendon.features import ROBOT_FACE
from kendon.geometry import Vec3
from kendon.models import DEFAULT_MODEL
from kendon.simulation.body import FACE_HEIGHT


class Part(Enum):
    """Which part of the flow a node does; the thesis ran two nodes (figure 4.1)."""

    BOTH = "both"  # reads the phases and answers them
    READING = "reading"  # reads the phases, tells the state
    ANSWERING = "answering"  # hears the state, answers it


class Input(Enum):
    """By what messages people are told of."""

    FACES = "faces"  # kendon_msgs/FaceExtraction (thesis 3.3)
    PEOPLE = "people"  # geometry_msgs/PoseArray (thesis 3.6.4)
    HUMANS = "humans"  # ROS4HRI: /humans/... and frames of /tf (REP-155)


class StateType(Enum):
    """The type of the topic that tells the phase's number."""

    STRING = "string"  # std_msgs/String, as the thesis's tree holds it
    INTEGER = "integer"  # std_msgs/Int32


@dataclass(frozen=True)
class NodeSettings:
    """How kendon's node behaves; each field is also a private parameter of the node.

    Raises:
        ParameterError: a number is out of its range.
    """

    part: Part = Part.BOTH
    input: Input = Input.FACES
    state_type: StateType = StateType.STRING
    model: str = DEFAULT_MODEL  # a model's name or file
    tree: str = ""  # a BehaviorTree.CPP XML file; empty = kendon's own
    robot_face: Vec3 = ROBOT_FACE  # in the base frame [m]
    base_frame: str = ""  # empty = base_footprint or base_link
    person: str = ""  # the id of the person, face or body to follow; empty = who is there
    face_height: float = FACE_HEIGHT  # of people whose poses lie on the ground [m]
    patience: float = 5.0  # how long the robot may be silent about a command [s]
    markers: bool = True  # whether to publish what rviz shows

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, self.robot_face)):
            raise ParameterError(f"robot_face is x,y,z in metres, not {self.robot_face}")
        if not 0.3 <= self.face_height <= 2.5:
            raise ParameterError(
                f"face_height lies between 0.3 and 2.5 m, not at {self.face_height:g}"
            )
        if not 0 < self.patience < math.inf:
            raise ParameterError(f"patience is a positive number of seconds, not {self.patience}")

    def with_values(self, values: Mapping[str, Any]) -> NodeSettings:
        """The same settings but for some, as texts or as ROS parameters give them.

        Raises:
            UnknownNameError: there is no such setting, or no such choice.
            ParameterError: a value is not what it should be.
        """
        known = {field.name: field for field in fields(self)}
        changed: dict[str, Any] = {}
        for name, value in values.items():
            if name not in known:
                raise UnknownNameError("parameter", name, known)
            changed[name] = _parsed(name, value, getattr(self, name))
        return replace(self, **changed)


def _parsed(name: str, value: Any, like: Any) -> Any:
    """A value as the type that a setting has."""
    if isinstance(like, Enum):
        choices = {choice.value: choice for choice in type(like)}
        if isinstance(value, type(like)):
            return value
        if str(value) not in choices:
            raise UnknownNameError(name, value, choices)
        return choices[str(value)]
    if isinstance(like, bool):
        if str(value).lower() not in ("true", "false", "1", "0"):
            raise ParameterError(f"{name} is true or false, not {value!r}")
        return str(value).lower() in ("true", "1")
    try:
        if isinstance(like, tuple):
            parts = value.split(",") if isinstance(value, str) else value
            x, y, z = (float(part) for part in parts)
            return (x, y, z)
        return type(like)(value)
    except (TypeError, ValueError):
        meaning = "X,Y,Z in metres" if isinstance(like, tuple) else "a number"
        raise ParameterError(f"{name} is {meaning}, not {value!r}") from None
