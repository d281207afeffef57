"""Robots that greet: the contract, and the reference robot with ideal kinematics."""

from kendon.robots.base import CHANNELS, Appearance, Command, CommandKind, CommandStatus, Robot
from kendon.robots.point import PointRobot

__all__ = [
    "CHANNELS",
    "Appearance",
    "Command",
    "CommandKind",
    "CommandStatus",
    "PointRobot",
    "Robot",
]
