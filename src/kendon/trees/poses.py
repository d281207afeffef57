"""Poses that carry their frame, and the geometry of the thesis's Algorithms 3 and 4."""

from __future__ import annotations

import math
from typing import NamedTuple

from kendon.errors import TreeError
from kendon.geometry import (
    UNKNOWN_ROTATION,
    Pose2D,
    Quaternion,
    Vec3,
    compose,
    quaternion_yaw,
    yaw_quaternion,
)

#: The robot's base frame and the world (REP-105).
BASE_FRAME, WORLD_FRAME = "base_footprint", "map"
FRAMES = (WORLD_FRAME, BASE_FRAME)


class Pose(NamedTuple):
    """A position and a rotation with the frame they are given in.

    The frame travels with the value, so that a node which reads a pose ticks later, when the
    robot has moved, still knows what it means. An empty frame is "not said": the reading node's
    `frame_id` port then tells.
    """

    position: Vec3  # [m]
    rotation: Quaternion = UNKNOWN_ROTATION
    frame: str = ""

    @property
    def yaw(self) -> float:
        """Where the pose's x axis points in the ground plane [rad]; NaN when unknown."""
        return quaternion_yaw(self.rotation)

    def in_world(self, robot: Pose2D, default_frame: str = WORLD_FRAME) -> Pose:
        """The same pose in `map`, for a robot whose base stands at `robot`.

        Raises:
            TreeError: the pose's frame is none of `FRAMES`.
        """
        frame = self.frame or default_frame
        if frame == WORLD_FRAME:
            return self
        if frame != BASE_FRAME:
            raise TreeError(f"a pose has the frame {frame!r}; valid: {', '.join(FRAMES)}")
        turned = compose(yaw_quaternion(robot.yaw), self.rotation)
        return Pose(robot.to_world(self.position), turned, WORLD_FRAME)

    def in_base(self, robot: Pose2D) -> Pose:
        """The same pose in `base_footprint`, for a robot whose base stands at `robot`."""
        world = self.in_world(robot)
        turned = compose(yaw_quaternion(-robot.yaw), world.rotation)
        return Pose(robot.to_local(world.position), turned, BASE_FRAME)


def ground_pose(goal: Pose2D) -> Pose:
    """A pose on the floor of the world as a `Pose`."""
    return Pose((goal.x, goal.y, 0.0), yaw_quaternion(goal.yaw), WORLD_FRAME)


def parse_pose(text: str) -> Pose:
    """A pose written out: ``x;y;z`` or ``x;y;z;qx;qy;qz;qw`` [m], with the frame not said.

    Raises:
        ValueError: the text is not three or seven finite numbers.

    >>> parse_pose("1;2;0").position
    (1.0, 2.0, 0.0)
    """
    numbers = [float(part) for part in text.split(";")]
    if len(numbers) not in (3, 7) or not all(math.isfinite(n) for n in numbers):
        raise ValueError(text)
    x, y, z, *rest = numbers
    if not rest:
        return Pose((x, y, z))
    qx, qy, qz, qw = rest
    norm = math.sqrt(qx * qx + qy * qy + qz * qz + qw * qw)
    if norm == 0:
        raise ValueError(text)
    return Pose((x, y, z), (qx / norm, qy / norm, qz / norm, qw / norm))


def turn_goal(person: Vec3, robot: Pose2D) -> Pose2D:
    """Where the robot turns to face a person without leaving its place (thesis, Algorithm 3).

    The person's position is already in the world, which is the algorithm's line 5.

    Args:
        person: the face in the world [m].
        robot: the base in the world.

    Returns:
        The robot's own position with the heading towards the person. A person exactly above the
        robot has no direction; the robot then keeps its heading (atan2(0, 0) would turn it
        to the world's x axis for no reason).
    """
    dx, dy = person[0] - robot.x, person[1] - robot.y
    if dx == 0 and dy == 0:
        return robot
    return Pose2D(robot.x, robot.y, math.atan2(dy, dx))


def approach_goal(person: Pose, robot: Pose2D, distance: float, *, retreat: bool = False) -> Pose2D:
    """Where the robot stands to greet a person from the front (thesis, Algorithm 4).

    With the person's heading known, the goal lies `distance` in front of the face and looks
    back at it (lines 8-10; the signs hold, since x points out of the face). Two additions:

    - A heading that is unknown leaves the line between the two: the goal lies on it, `distance`
      from the person, and looks along it.
    - A robot that is already nearer than `distance` keeps its place and turns to the person,
      unless `retreat` is true. The algorithm as printed would send it backwards, away from
      somebody who is stepping up to shake its hand.

    Args:
        person: the face in the world; its yaw is the person's heading.
        robot: the base in the world.
        distance: to keep between the robot and the person [m].
        retreat: whether the robot backs off from a person who is nearer than that.

    Returns:
        The goal of the base in the world.
    """
    x, y, _ = person.position
    away = math.hypot(robot.x - x, robot.y - y)
    if away < distance and not retreat:
        return turn_goal(person.position, robot)
    heading = person.yaw
    if not math.isfinite(heading):
        # Standing on the very same spot leaves no line either: step back along the own heading.
        heading = math.atan2(robot.y - y, robot.x - x) if away > 0 else robot.yaw + math.pi
    return Pose2D(
        x + distance * math.cos(heading),
        y + distance * math.sin(heading),
        math.remainder(heading + math.pi, 2 * math.pi),
    )


def gaze_down(face: Pose) -> Pose:
    """The face's pose at half its height above the ground (thesis 4.1.2, Head Dip)."""
    x, y, z = face.position
    return face._replace(position=(x, y, z / 2))
