"""Ros2Robot: the contract, with a look-alike's process at the other end of DDS, in its time."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("cyclonedds", reason="the extra 'ros2' is not installed")
pytest.importorskip("rosbags", reason="the extra 'ros2' is not installed")
from robots.robot_contract import RobotContract, run_until_ended
from ros2_peers import CLOCK, LIMIT, LOOPBACK, ODOMETRY, free_domain, peer, stamp, until

from kendon.errors import RobotError
from kendon.geometry import Pose2D
from kendon.robots.base import CommandStatus, Robot
from kendon.ros.dds import DdsNode
from kendon.ros.ros2_robot import Ros2Robot
from kendon.ros.ros2_settings import Drive, HeardPlace, Ros2Settings
from kendon.ros.ros2_transport import Offer


class Link:
    """The other end: its time is this one's, and it has answered before a step is over."""

    def __init__(self, node: DdsNode) -> None:
        self.node = node
        self.place = HeardPlace()
        self.time = 0.0
        self.heard = 0.0  # [s], the stamp of the newest odometry
        node.advertise("/clock", CLOCK)
        until(node, lambda: "/odom" in node.offers() and "/clock" in node.asked())
        node.subscribe("/odom", Offer(ODOMETRY, True, False), self._take)

    def _take(self, raw: bytes, message: Any, sent: int) -> None:
        self.heard = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
        self.place.take_localised(message)

    def step(self, dt: float) -> None:
        self.time += dt
        self.node.publish("/clock", CLOCK, {"clock": stamp(self.time)})
        until(self.node, lambda: self.heard > self.time - 1e-6)


LINKS: list[Link] = []


class InStep(Ros2Robot):
    """Waits in each step for the look-alike, whose steps these are."""

    drive = Drive.GOAL_POSE

    def __init__(self, *, patience: float = 5.0) -> None:
        self.link = LINKS[-1]
        settings = Ros2Settings(self.drive, position_tolerance=0.06, yaw_tolerance=0.05)
        super().__init__(
            self.link.node, self.link.place, settings,
            clock=lambda: round(self.link.time * 1e9), patience=patience,
        )  # fmt: skip
        topic = "/goal_pose" if self.drive is Drive.GOAL_POSE else "/cmd_vel"
        until(self.link.node, lambda: topic in self.link.node.asked())

    def _advance(self, dt: float) -> None:
        if dt:
            self.link.step(dt)
        super()._advance(dt)


class ByVelocity(InStep):
    drive = Drive.CMD_VEL


@pytest.fixture(scope="module", autouse=True)
def link() -> Iterator[Link]:
    domain = free_domain()
    os.environ["CYCLONEDDS_URI"] = LOOPBACK
    with peer("robot", str(domain)):
        node = DdsNode(domain)
        LINKS.append(Link(node))
        yield LINKS[-1]
        node.close()
        LINKS.clear()


def at_rest(robot: InStep) -> Robot:
    """The robot after whatever the last test left it doing."""
    robot.update(0.1)
    run_until_ended(robot, robot.stop())
    robot.log.clear()
    return robot


class TestContractByGoals(RobotContract):
    def make(self) -> Robot:
        return at_rest(InStep())


class TestContractByVelocities(RobotContract):
    def make(self) -> Robot:
        return at_rest(ByVelocity())


@pytest.mark.parametrize("kind", [InStep, ByVelocity])
def test_it_gets_to_where_it_is_sent(kind: type[InStep]) -> None:
    robot = at_rest(kind())
    goal = Pose2D(robot.pose.x + 1.0, robot.pose.y + 0.5, 1.0)
    drive = robot.go_to(goal)
    run_until_ended(robot, drive)
    assert drive.status is CommandStatus.SUCCEEDED
    assert robot.pose.distance_to(goal) < 0.06
    assert robot.pose.yaw == pytest.approx(goal.yaw, abs=0.05)


@pytest.mark.parametrize("kind", [InStep, ByVelocity])
def test_it_keeps_its_distance_from_the_person(kind: type[InStep]) -> None:
    robot = at_rest(kind())
    robot.person = robot.pose.to_world((2.0, 0.0, 1.6))
    x, y, _ = robot.person
    drive = robot.go_to(Pose2D(x, y, robot.pose.yaw))
    nearest = 9.0
    while drive.running and robot.time < LIMIT:
        robot.update(robot.time + 0.1)
        nearest = min(nearest, robot.pose.distance_to(Pose2D(x, y, 0.0)))
    assert drive.status is CommandStatus.SUCCEEDED
    assert drive.reason
    assert 0.9 < nearest < 1.1


def test_a_command_that_nobody_reads_fails_in_time(link: Link) -> None:
    place = HeardPlace()
    robot = Ros2Robot(link.node, place, Ros2Settings(), clock=lambda: 0, patience=2.0)
    with pytest.raises(RobotError, match="nobody tells where the robot is"):
        robot._located()
    assert robot.go_to(Pose2D(1.0, 0.0, 0.0)).status is CommandStatus.FAILED
