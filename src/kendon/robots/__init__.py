"""Robots that greet: the contract, the reference robot with ideal kinematics, and bodies."""

from kendon.robots.base import CHANNELS, Command, CommandKind, CommandStatus, Robot
from kendon.robots.point import PointRobot
from kendon.robots.registry import (
    DEFAULT_ROBOT,
    RobotKind,
    RobotOptions,
    make_robot,
    robot_kinds,
)

__all__ = [
    "CHANNELS",
    "DEFAULT_ROBOT",
    "Command",
    "CommandKind",
    "CommandStatus",
    "PointRobot",
    "Robot",
    "RobotKind",
    "RobotOptions",
    "make_robot",
    "robot_kinds",
]
