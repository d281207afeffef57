"""People by their poses alone, as a simulator's ground truth tells them (thesis 3.6.4)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from kendon.errors import DataError
from kendon.geometry import Pose2D, Vec3, compose, yaw_quaternion
from kendon.person import PersonFrame
from kendon.sources.ros_place import FARTHEST, WORLDS

#: How far off the ground a pose lies at most that tells where somebody stands [m].
_ON_THE_GROUND = 0.5
#: How much nearer than the one who is greeted somebody else must be to be greeted instead [m].
_NEARER = 0.5


class People:
    """Picks the person to greet out of a ``geometry_msgs/PoseArray``, message by message.

    The nearest one is greeted, and kept until somebody else is clearly nearer. A person is known
    by their place in the list. A pose on the ground is where somebody stands, one above it is
    that of their face.

    Args:
        height: of the faces of people whose poses lie on the ground [m].
        bases: the names that the robot's base frame may have.
    """

    def __init__(self, height: float, bases: tuple[str, ...]) -> None:
        self.height = height
        self.bases = bases
        self._target: int | None = None

    def frame(self, message: Any, t: float, robot: Pose2D, who: Sequence[int]) -> PersonFrame:
        """The person to greet, or a frame without anybody.

        Args:
            message: with the fields of its definition.
            t: when it holds [s].
            robot: where the robot was then.
            who: what each of the people is known by to the flow.

        Raises:
            DataError: it is given neither in the world nor in the robot's base frame, or has a
                number that no place has.
        """
        frame = message.header.frame_id.lstrip("/")
        if frame and frame not in (*WORLDS, *self.bases):
            raise DataError(
                f"people are given in the world ({', '.join(WORLDS)}) or in the robot's base frame"
                f" ({', '.join(self.bases)}), not in {frame!r}"
            )
        found = [
            self._person(pose, t, robot, in_base=frame in self.bases) for pose in message.poses
        ]
        ways = [math.hypot(p.head[0], p.head[1]) for p in found]
        near = min(
            (i for i, way in enumerate(ways) if way == way), key=ways.__getitem__, default=-1
        )
        if near < 0:
            return PersonFrame(t, robot=robot)
        kept = self._target
        if kept is None or kept >= len(ways) or not ways[kept] <= ways[near] + _NEARER:
            self._target = kept = near
        person = found[kept]
        return PersonFrame(t, person.head, person.head_rotation, robot=robot, who=who[kept])

    def _person(self, pose: Any, t: float, robot: Pose2D, *, in_base: bool) -> PersonFrame:
        p, q = pose.position, pose.orientation
        if far := [value for value in (p.x, p.y, p.z) if abs(value) > FARTHEST]:  # NaN is not
            raise DataError(f"a coordinate of {far[0]:g} m is not on Earth")
        head: Vec3 = (p.x, p.y, p.z if p.z > _ON_THE_GROUND else p.z + self.height)
        rotation = (q.x, q.y, q.z, q.w)
        if not in_base:
            head = robot.to_local(head)
            rotation = compose(yaw_quaternion(-robot.yaw), rotation)
        length = math.hypot(*rotation)
        if not abs(length - 1) < 1e-2:  # an orientation nobody filled in
            rotation = (math.nan, math.nan, math.nan, math.nan)
        return PersonFrame(t, head, rotation, robot=robot)
