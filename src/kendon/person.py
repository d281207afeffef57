"""What kendon knows of one person: at one instant (`PersonFrame`) and over time (`Track`)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from kendon.errors import DataError
from kendon.geometry import (
    ORIGIN,
    UNKNOWN_POINT,
    UNKNOWN_ROTATION,
    Pose2D,
    Quaternion,
    Vec3,
    compose,
    yaw_quaternion,
)

FloatArray = NDArray[np.float64]

#: The joints of the upper body, the person's own left and right.
JOINTS: tuple[str, ...] = tuple(
    f"{side}_{joint}" for side in "lr" for joint in ("shoulder", "elbow", "wrist", "hip")
)

#: The gesture probabilities that can be given by hand, as the thesis's keys gave them.
GESTURES: tuple[str, ...] = ("dsal", "csal", "hdip")

#: Farther than this nobody is greeted; a larger coordinate is a mistaken unit [m].
MAX_COORDINATE = 100.0

_NO_JOINTS: Mapping[str, Vec3] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class PersonFrame:
    """One person at one instant, seen from the robot. What is not known is NaN.

    Points and directions are in the robot's ``base_footprint`` at that instant (REP-105).
    """

    t: float  # [s]
    head: Vec3 = UNKNOWN_POINT  # [m], the face
    head_rotation: Quaternion = UNKNOWN_ROTATION  # x out of the face, y to the person's left, z up
    eyes: tuple[Vec3, Vec3] | None = None  # [m], centres of the person's left and right eye
    eye_gaze: tuple[Vec3, Vec3] | None = None  # directions out of those eyes
    joints: Mapping[str, Vec3] = _NO_JOINTS  # [m], by the names in JOINTS
    smile: float = math.nan  # [0-5], the mean of AU06 and AU12 (thesis 3.11)
    dsal: float = math.nan  # [probability], given by hand
    csal: float = math.nan  # [probability], given by hand
    hdip: float = math.nan  # [probability], given by hand
    robot: Pose2D = ORIGIN  # the robot's pose in the world at that instant

    @property
    def seen(self) -> bool:
        """Whether the face's position is known."""
        return math.isfinite(self.head[0]) and math.isfinite(self.head[1])

    def seen_from(self, robot: Pose2D) -> PersonFrame:
        """The same person at the same instant, seen from a robot that stands at `robot`."""
        if robot == self.robot:
            return self
        old = self.robot
        turn = yaw_quaternion(old.yaw - robot.yaw)

        def move(point: Vec3) -> Vec3:
            return robot.to_local(old.to_world(point))

        def rotate(direction: Vec3) -> Vec3:
            c, s = math.cos(old.yaw - robot.yaw), math.sin(old.yaw - robot.yaw)
            x, y, z = direction
            return (c * x - s * y, s * x + c * y, z)

        return replace(
            self,
            head=move(self.head),
            head_rotation=compose(turn, self.head_rotation),
            eyes=self.eyes and (move(self.eyes[0]), move(self.eyes[1])),
            eye_gaze=self.eye_gaze and (rotate(self.eye_gaze[0]), rotate(self.eye_gaze[1])),
            joints={name: move(point) for name, point in self.joints.items()},
            robot=robot,
        )
