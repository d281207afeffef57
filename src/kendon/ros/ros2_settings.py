"""What is known of a robot of ROS 2, and where it tells that it is."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from kendon.errors import ParameterError
from kendon.geometry import Vec3
from kendon.robots.drive import BaseLimits
from kendon.robots.driving import check
from kendon.sources.ros_place import WORLDS, RobotPlace

#: Nobody waits longer for a message [s].
MAX_LATENESS = 60.0


def check_lateness(name: str, seconds: float) -> None:
    """Refuse what cannot be how late messages may be.

    Raises:
        ParameterError: it is out of its range; `name` is what the user calls it.
    """
    if not 0 < seconds <= MAX_LATENESS:
        raise ParameterError(
            f"{name} is more than 0, and at most {MAX_LATENESS:g} s, not {seconds:g}"
        )


class Drive(StrEnum):
    """How the base is driven."""

    GOAL_POSE = "goal_pose"  # Nav2 plans and drives; it also knows of obstacles
    CMD_VEL = "cmd_vel"  # kendon's own approach controller; it knows of the person alone


@dataclass(frozen=True)
class Ros2Topics:
    """Where a robot listens."""

    goal: str = "/goal_pose"
    velocity: str = "/cmd_vel"
    look: str = "/look_at"
    gesture: str = "/gesture"
    say: str = "/say"
    express: str = "/expression"


@dataclass(frozen=True)
class Ros2Settings:
    """What is known of a robot."""

    drive: Drive = Drive.GOAL_POSE
    topics: Ros2Topics = field(default_factory=Ros2Topics)
    world: str = ""  # the frame in which goals are given; empty = that of the robot's place
    face: Vec3 = (0.0, 0.0, 1.2)  # in the base frame [m]
    limits: BaseLimits = field(default_factory=BaseLimits)  # for `Drive.CMD_VEL`
    keep_distance: float = 1.0  # [m] from the person (thesis 4.1.2)
    leash: float | None = None  # [m] from where it started; 0 only turns, None is free
    position_tolerance: float = 0.25  # [m], Nav2's own (nav2_controller)
    yaw_tolerance: float = 0.25  # [rad], likewise

    def __post_init__(self) -> None:
        check("keep_distance", self.keep_distance, "m", zero=True)
        check("position_tolerance", self.position_tolerance, "m")
        check("yaw_tolerance", self.yaw_tolerance, "rad")
        if self.leash is not None:
            check("leash", self.leash, "m", zero=True)


class HeardPlace(RobotPlace):
    """Where the robot is, and how often that was told: the base's sign of life."""

    told = 0

    def take_localised(self, message: Any) -> None:
        """Take in a message with a pose, such as an Odometry."""
        super().take_localised(message)
        if not self.by_frames:
            self.world = message.header.frame_id.lstrip("/") or self.world
        self.told += 1

    def take_transforms(self, message: Any, *, static: bool = False) -> None:
        """Take in the transforms of a message of ``/tf`` or ``/tf_static``."""
        super().take_transforms(message, static=static)
        frames = (*self.bases, *WORLDS)
        self.told += any(t.child_frame_id.lstrip("/") in frames for t in message.transforms)
