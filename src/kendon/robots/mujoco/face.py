"""The face of a robot with a body: expressions that its joints change to."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from kendon.person import FloatArray
from kendon.robots.mujoco.body import Body
from kendon.robots.point import EXPRESSION_SECONDS


class Face:
    """Shows expressions, one changing into the next.

    Args:
        body: whose.
        expressions: by name, where joints are in it, in the units of the robot's file.

    Raises:
        DataError: a joint is unknown or its value out of its range.
    """

    def __init__(self, body: Body, expressions: Mapping[str, Mapping[str, float]]) -> None:
        found = {
            name: body.set_points(f"expressions.{name}", joints)
            for name, joints in expressions.items()
        }
        joints = sorted({joint for points in found.values() for joint in points})
        self._joints = np.array(joints, dtype=np.int64)
        self._rest: FloatArray = body.rest[self._joints]
        self._ways = {
            name: np.array([points.get(j, body.rest[j]) for j in joints]) - self._rest
            for name, points in found.items()
        }
        self.names = tuple(found)
        self._from = self._to = self._rest
        self.until = -math.inf  # [s], when it has changed
        self.expression, self.level = "neutral", 1.0
        self._levels: tuple[float, float] = (0.0, 1.0)  # the intensity before and after the change

    def show(self, expression: str, intensity: float, now: float) -> None:
        """Begin to change to an expression, at a time [s]."""
        same = expression == self.expression
        self._levels = (self.level if same else 0.0, intensity)
        self.expression, self.level = expression, self._levels[0]
        self._from = self._at(now)
        self._to = self._rest + intensity * self._ways[expression]
        self.until = now + EXPRESSION_SECONDS

    def follow(self, left: float) -> None:
        """Note how intense the expression is, so long before it has changed [s]."""
        share = max(0.0, left) / EXPRESSION_SECONDS
        self.level = self._levels[1] - (self._levels[1] - self._levels[0]) * share

    def pose(self, targets: FloatArray, now: float) -> None:
        """Set the face's set-points [rad or m] at a time [s]."""
        if len(self._joints):
            targets[self._joints] = self._at(now)

    def _at(self, now: float) -> FloatArray:
        left = min(1.0, (self.until - now) / EXPRESSION_SECONDS)
        if left <= 0:
            return self._to
        face: FloatArray = self._to + (self._from - self._to) * left
        return face
