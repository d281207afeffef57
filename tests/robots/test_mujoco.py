"""MujocoRobot: the contract."""

from __future__ import annotations

from robots.robot_contract import RobotContract

from kendon.geometry import Pose2D
from kendon.robots.base import Robot
from kendon.robots.mujoco import MujocoRobot


class TestMujocoRobotContract(RobotContract):
    def make(self) -> Robot:
        return MujocoRobot()


class TestMujocoRobotContractElsewhere(RobotContract):
    """Nothing may depend on starting at the origin and alone."""

    def make(self) -> Robot:
        robot = MujocoRobot(Pose2D(-3.0, 2.0, 2.5), leash=2.0)
        robot.person = (-1.0, -6.0, 1.6)
        return robot
