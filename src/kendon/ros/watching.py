"""A robot that is somebody else's: it is where it is told to be, and is given no commands."""

from __future__ import annotations

from typing import Any

from kendon.geometry import Pose2D, Vec3
from kendon.robots.base import Command, Robot
from kendon.sources.ros_place import RobotPlace


class Watcher(Robot):
    """Stands for the robot where only its place counts.

    Args:
        place: where it is.
        face: its face in its base frame [m].
    """

    def __init__(self, place: RobotPlace, face: Vec3) -> None:
        super().__init__()
        self._place, self._face = place, face

    @property
    def pose(self) -> Pose2D:
        """The pose of the base in the world."""
        return self._place.pose

    @property
    def face(self) -> Vec3:
        """The robot's face in its base frame [m]."""
        return self._face

    def _send(self, command: Command) -> dict[str, Any]:
        return dict(command.asked)

    def _abort(self, command: Command) -> None:
        del command

    def _advance(self, dt: float) -> None:
        del dt
