"""What a simulated person sees of a robot: where it is, and, a little late, what it does."""

from __future__ import annotations

import math
from collections import deque

from kendon.geometry import Pose2D
from kendon.robots.base import Appearance
from kendon.simulation.actor import Actor


class Sight:
    """A robot in a person's eyes.

    Args:
        actor: the person.
        late: how many appearances of the robot later they notice what it does.
    """

    def __init__(self, actor: Actor, late: int) -> None:
        self._actor = actor
        self._seen: deque[Appearance] = deque(maxlen=1 + late)

    def take(self, robot: Appearance) -> None:
        """Take in how the robot looks now."""
        self._seen.append(robot)

    @property
    def pose(self) -> Pose2D:
        """Where the robot is."""
        return self._seen[-1].pose

    @property
    def noticed(self) -> Appearance:
        """The robot as the person has noticed it, a little late."""
        return self._seen[0]

    @property
    def away(self) -> float:
        """How far the robot is [m]."""
        pose = self._seen[-1].pose
        return math.hypot(self._actor.x - pose.x, self._actor.y - pose.y)

    @property
    def coming_at(self) -> float:
        """How fast the robot comes nearer by its own motion [m/s]."""
        first, last = self._seen[0], self._seen[-1]
        if last.t <= first.t:
            return 0.0
        x, y = self._actor.place
        before, after = (math.hypot(x - a.pose.x, y - a.pose.y) for a in (first, last))
        return (before - after) / (last.t - first.t)

    @property
    def hand_offered(self) -> bool:
        """Whether the robot holds out its hand."""
        return self.noticed.gesture == "handshake"

    @property
    def saluted(self) -> bool:
        """Whether the robot says or shows anything that may pass for a salutation."""
        return self.noticed.gesture not in (None, "home") or self.noticed.speech is not None
