"""Robots with a body in MuJoCo: kendon's Vizzy, or any MJCF or URDF with a mapping file."""

from kendon.robots.mujoco.description import RobotDescription, read_description
from kendon.robots.mujoco.robot import MujocoRobot

__all__ = ["MujocoRobot", "RobotDescription", "read_description"]
