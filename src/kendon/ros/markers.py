"""What rviz shows of a greeting: the person, their gaze, the zones, the phase, the goal.

Shapes know nothing of ROS; `fill_marker` writes one into a ``visualization_msgs/Marker``, whose
numbers for types are the same in both generations of ROS.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import pairwise
from typing import Any

import numpy as np

from kendon.features.gaze import CONE_ANGLE
from kendon.geometry import Pose2D, Quaternion, Vec3, yaw_quaternion
from kendon.greeter import Moment
from kendon.person import FloatArray
from kendon.phases import Phase
from kendon.robots.base import CommandKind, Robot

#: Hall's (1966) outer borders of the intimate, the personal and the social distance [m].
ZONES = (0.45, 1.2, 3.6)
#: The part of the gaze cone that is drawn [m], and how many sides it has.
_CONE_LENGTH, _CONE_SIDES = 0.8, 24
_CIRCLE_CORNERS = 72
_HEAD_SIZE = 0.24  # [m], from chin to crown
_NO_TURN: Quaternion = (0.0, 0.0, 0.0, 1.0)
Color = tuple[float, float, float, float]


class ShapeType(Enum):
    """The numbers of ``visualization_msgs/Marker``."""

    ARROW = 0
    SPHERE = 2
    CYLINDER = 3
    LINE_STRIP = 4
    TEXT = 9
    TRIANGLES = 11


@dataclass(frozen=True)
class Shape:
    """One thing to show; where it is not shown any more, it is deleted by its name and number."""

    name: str
    type: ShapeType
    color: Color
    scale: Vec3
    position: Vec3 = (0.0, 0.0, 0.0)
    rotation: Quaternion = _NO_TURN
    points: Sequence[Vec3] = ()
    text: str = ""
    number: int = 0
    in_world: bool = field(default=False)  # or else in the robot's base frame


def shapes(moment: Moment, robot: Robot) -> Iterator[Shape]:
    """Everything to show after a moment, in the base frame but for the goal.

    The same names come each time, in the same order, but for what is not known.
    """
    for number, radius in enumerate(ZONES):
        yield Shape(
            "zones", ShapeType.LINE_STRIP, (0.6, 0.6, 0.6, 0.8), (0.02, 0.0, 0.0),
            points=_circle(radius), number=number,
        )  # fmt: skip
    color = _color(moment.belief.phase if moment.belief else None)
    person = moment.person
    if person is not None and person.seen:
        x, y, z = person.head
        z = z if math.isfinite(z) else robot.face[2]
        middle = max(0.05, z - _HEAD_SIZE / 2)
        body = (0.35, 0.35, middle)
        yield Shape("person", ShapeType.CYLINDER, color, body, (x, y, middle / 2))
        yield Shape("person", ShapeType.SPHERE, color, (_HEAD_SIZE,) * 3, (x, y, z), number=1)
        if all(map(math.isfinite, person.head_rotation)):
            yield Shape(
                "gaze", ShapeType.TRIANGLES, (*color[:3], 0.35), (1.0, 1.0, 1.0), (x, y, z),
                person.head_rotation, _cone(),
            )  # fmt: skip
        yield Shape(
            "phase", ShapeType.TEXT, color, (0.0, 0.0, 0.15), (x, y, z + 0.35),
            text=_label(moment),
        )  # fmt: skip
    drive = robot.running(CommandKind.GO_TO)
    if drive is not None:
        goal: Pose2D = drive.asked["goal"]
        yield Shape(
            "goal", ShapeType.ARROW, (0.0, 0.62, 0.45, 0.9), (0.5, 0.08, 0.08),
            (goal.x, goal.y, 0.05), yaw_quaternion(goal.yaw), in_world=True,
        )  # fmt: skip


def fill_marker(message: Any, shape: Shape, point: Callable[..., Any]) -> Any:
    """Write a shape into a ``visualization_msgs/Marker``, except its header; return it."""
    message.ns, message.id, message.type, message.action = (
        shape.name, shape.number, shape.type.value, 0,
    )  # fmt: skip
    place, turn = message.pose.position, message.pose.orientation
    place.x, place.y, place.z = shape.position
    turn.x, turn.y, turn.z, turn.w = shape.rotation
    message.scale.x, message.scale.y, message.scale.z = shape.scale
    message.color.r, message.color.g, message.color.b, message.color.a = shape.color
    message.points = [point(*corner) for corner in shape.points]
    message.text = shape.text
    return message


def _label(moment: Moment) -> str:
    if moment.belief is None:
        return ""
    shown = [
        f"{phase.name} {share:.0%}"
        for phase, share in zip(Phase, moment.belief.probabilities.tolist(), strict=True)
        if share >= 0.005
    ]
    return "\n".join([moment.belief.phase.title, "  ".join(shown)])


def _color(phase: Phase | None) -> Color:
    text = phase.color if phase else "#999999"
    red, green, blue = (int(text[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return (red, green, blue, 1.0)


def _circle(radius: float) -> list[Vec3]:
    angles: FloatArray = np.linspace(0, 2 * np.pi, _CIRCLE_CORNERS + 1)
    return [(radius * math.cos(a), radius * math.sin(a), 0.01) for a in angles.tolist()]


def _cone() -> list[Vec3]:
    """The cone of attention about the x axis (thesis 3.3.3), its tip at the origin."""
    width = _CONE_LENGTH * math.tan(CONE_ANGLE / 2)
    angles = np.linspace(0, 2 * np.pi, _CONE_SIDES + 1).tolist()
    rim = [(_CONE_LENGTH, width * math.cos(a), width * math.sin(a)) for a in angles]
    return [p for pair in pairwise(rim) for p in ((0.0, 0.0, 0.0), *pair)]
