"""Robots that greet: the contract, and the reference robot with ideal kinematics."""

from kendon.robots.base import CHANNELS, Command, CommandKind, CommandStatus, Robot
from kendon.robots.point import PointRobot

__all__ = ["CHANNELS", "Command", "CommandKind", "CommandStatus", "PointRobot", "Robot"]
