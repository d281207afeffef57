"""Vizzy over a real master, against servers like its own in another process."""

from __future__ import annotations

import signal
import subprocess
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from robots.robot_contract import COMMANDS, RobotContract, run_until_ended
from ros1.ros1_world import Master, tells, wait_for

from kendon.geometry import Pose2D
from kendon.robots.base import CommandStatus, Robot
from kendon.ros.ros1.environment import ros_module
from kendon.ros.ros1.vizzy import Vizzy

#: How fast the wall's clock goes by the robot's: the servers take their time by the wall.
PACE = 0.4


class PacedVizzy(Vizzy):
    """Vizzy whose clock, which the tests drive as fast as they can, does not run away."""

    def _advance(self, dt: float) -> None:
        threading.Event().wait(PACE * dt)
        super()._advance(dt)


def connected() -> PacedVizzy:
    robot = PacedVizzy()
    assert robot.missing(30.0) == []
    wait_for(lambda: robot.place.known, "the robot's pose")
    return robot


def settle(robot: Robot) -> None:
    run_until_ended(robot, robot.stop())


@pytest.fixture(scope="module")
def obeying(master: Master) -> Iterator[subprocess.Popen[str]]:
    with master.servers("obey") as process:
        yield process


@pytest.mark.usefixtures("obeying")
class TestVizzy(RobotContract):
    def make(self) -> PacedVizzy:
        return connected()

    @pytest.fixture
    def robot(self) -> Iterator[PacedVizzy]:
        robot = self.make()
        yield robot
        robot.__dict__.pop("_abort", None)  # what a test has put there in its place
        settle(connected())

    def test_it_drives_where_it_is_told(self, robot: Robot) -> None:
        goal = Pose2D(robot.pose.x + 1.0, robot.pose.y - 0.5, 1.0)
        run_until_ended(robot, robot.go_to(goal))
        wait_for(lambda: robot.pose.distance_to(goal) < 1e-6, "the pose at the goal")
        assert robot.pose.yaw == pytest.approx(1.0)

    def test_an_arm_that_is_cancelled_goes_home_but_not_on_the_way_to_another_routine(
        self, robot: Robot
    ) -> None:
        heard: list[int] = []
        rospy = ros_module("rospy")
        listening = rospy.Subscriber(
            "arms_heard", ros_module("std_msgs.msg").Int16, lambda m: heard.append(m.data)
        )
        wait_for(lambda: tells("/vizzy_servers", "/arms_heard"), "the arms' publisher")
        robot.gesture("wave")
        robot.gesture("handshake").cancel()
        wait_for(lambda: len(heard) == 3, "three routines")
        listening.unregister()
        assert heard == [1, 3, 0]

    def test_what_was_really_sent_is_told(self, robot: Robot) -> None:
        said = robot.say("Muito prazer", "pt")
        assert (said.sent["language"], said.sent["voice"]) == ("pt_PT", "pt-PT-Wavenet-D")
        assert robot.gesture("angry").sent["routine"] == 10

    def test_a_stop_that_reaches_the_robot_late_spares_what_came_after_it(
        self, robot: PacedVizzy, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        cancels = robot._base._client.pub_cancel
        held: list[Any] = []
        with monkeypatch.context() as patch:
            patch.setattr(cancels, "publish", held.append)
            COMMANDS["go_to"](robot)
            robot.stop()
            drive = COMMANDS["go_to"](robot)
        robot.update(robot.time + 0.5)
        for message in held:
            cancels.publish(message)
        run_until_ended(robot, drive)
        assert (drive.status, drive.reason) == (CommandStatus.SUCCEEDED, "")

    def test_another_node_that_takes_over_fails_the_command(self, robot: Robot) -> None:
        other = connected()
        drive = COMMANDS["go_to"](robot)
        other.go_to(Pose2D(0.0, 0.0, 0.0))
        run_until_ended(robot, drive)
        assert (drive.status, drive.reason) == (
            CommandStatus.FAILED,
            "another node has taken over",
        )


ACTIONS = ["go_to", "turn_to", "look_at", "say"]


@pytest.mark.parametrize(
    ("behaviour", "reason"),
    [
        ("abort", "the robot gave up: the way is barred"),
        ("refuse", "the robot refused: not today"),
    ],
)
def test_a_server_that_does_not_do_it_is_quoted(
    master: Master, behaviour: str, reason: str
) -> None:
    with master.servers(behaviour):
        robot = connected()
        for name in ACTIONS:
            command = COMMANDS[name](robot)
            run_until_ended(robot, command)
            assert (command.status, command.reason) == (CommandStatus.FAILED, reason)


def test_servers_that_fall_silent_fail_their_commands_in_time(master: Master) -> None:
    with master.servers() as process:
        robot = connected()
        commands = [COMMANDS[name](robot) for name in ("go_to", "look_at", "say")]
        process.send_signal(signal.SIGSTOP)
        began = robot.time
        for command in commands:
            run_until_ended(robot, command)
            assert command.status is CommandStatus.FAILED
            assert command.reason == "the robot has not answered for 5 s"
        assert robot.time - began <= robot.patience + 0.5
        stop = robot.stop()
        run_until_ended(robot, stop)
        process.send_signal(signal.SIGCONT)


def test_servers_that_vanish_fail_their_commands_and_refuse_new_ones(master: Master) -> None:
    with master.servers() as process:
        robot = connected()
        drive = COMMANDS["go_to"](robot)
        process.kill()
        run_until_ended(robot, drive)
        assert drive.status is CommandStatus.FAILED
        assert drive.ended - drive.issued <= robot.patience + 0.5
        wait_for(lambda: len(robot.missing()) == 5, "the servers' absence")
        for name, command in COMMANDS.items():
            refused = command(robot)
            assert refused.status is CommandStatus.FAILED, name
            assert ("no action server answers at /" in refused.reason) or (
                "nobody listens to /" in refused.reason
            )


def test_without_servers_commands_are_refused_at_once(master: Master) -> None:
    robot = PacedVizzy()
    assert robot.missing() == [
        "/move_base", "/gaze", "/gcloud_tts", "/vizzyArmRoutines/command", "/expression",
    ]  # fmt: skip
    drive = robot.go_to(Pose2D(1.0, 0.0, 0.0))
    assert (drive.status, drive.reason) == (
        CommandStatus.FAILED,
        "no action server answers at /move_base",
    )
