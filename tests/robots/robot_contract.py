"""What every robot must do, whatever it is made of.

A robot's test module inherits from `RobotContract` and says how to make the robot::

    class TestMyRobot(RobotContract):
        def make(self) -> Robot:
            return MyRobot()

The commands are small (25 cm, half a second of speech), so that a slow robot can run the tests.
"""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import pytest

from kendon.errors import ParameterError, RobotError, UnknownNameError
from kendon.geometry import Pose2D
from kendon.robots.base import CHANNELS, Command, CommandKind, CommandStatus, Robot

COMMANDS: dict[str, Callable[[Robot], Command]] = {
    "go_to": lambda robot: robot.go_to(Pose2D(robot.pose.x + 0.25, robot.pose.y, robot.pose.yaw)),
    "turn_to": lambda robot: robot.turn_to(robot.pose.yaw + 0.5),
    "look_at": lambda robot: robot.look_at(robot.pose.to_world((2.0, 1.0, 1.5))),
    "gesture": lambda robot: robot.gesture("wave"),
    "say": lambda robot: robot.say("Muito prazer", "pt"),
    "express": lambda robot: robot.express("smile", 0.8),
}
each_command = pytest.mark.parametrize("issue", COMMANDS.values(), ids=COMMANDS.keys())


def state(command: Command) -> tuple[Any, ...]:
    """All that may be read off a handle."""
    return (
        command.kind, dict(command.asked), dict(command.sent), command.issued, command.status,
        command.reason, str(command.ended), command.heard,
    )  # fmt: skip


def run_until_ended(robot: Robot, command: Command, limit: float = 20.0) -> None:
    """Let time pass at 10 Hz until the command has ended."""
    deadline = robot.time + limit
    while command.running:
        assert robot.time < deadline, f"{command} has not ended within {limit} s"
        robot.update(robot.time + 0.1)


class RobotContract(ABC):
    """The tests every robot passes; `make` gives a fresh one that stands still."""

    @abstractmethod
    def make(self) -> Robot:
        """A robot of the kind under test."""

    @pytest.fixture
    def robot(self) -> Robot:
        return self.make()

    @each_command
    def test_a_command_returns_at_once_with_a_handle(
        self, robot: Robot, issue: Callable[[Robot], Command], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        sleep = time.sleep

        def wait(seconds: float) -> None:
            # Threads of the robot's own may wait; sleep(0) only lets them run.
            here = threading.current_thread() is threading.main_thread()
            assert seconds == 0 or not here, "a command must not wait"
            sleep(seconds)

        monkeypatch.setattr(time, "sleep", wait)
        clock, pose = robot.time, robot.pose
        command = issue(robot)
        assert (robot.time, robot.pose) == (clock, pose)  # what takes time happens in `update`
        assert command.running
        assert command.issued == robot.time
        assert math.isnan(command.ended)
        assert command.sent.keys() >= command.asked.keys()
        assert robot.running(command.kind) is command

    @each_command
    def test_a_command_succeeds_in_the_end(
        self, robot: Robot, issue: Callable[[Robot], Command]
    ) -> None:
        command = issue(robot)
        run_until_ended(robot, command)
        assert (command.status, command.reason) == (CommandStatus.SUCCEEDED, "")
        assert command.issued < command.ended <= robot.time
        assert robot.running(command.kind) is None

    @each_command
    def test_a_new_command_replaces_the_one_on_its_channel(
        self, robot: Robot, issue: Callable[[Robot], Command]
    ) -> None:
        old = issue(robot)
        robot.update(robot.time + 0.05)
        new = issue(robot)
        assert old.status is CommandStatus.CANCELLED
        assert old.reason == f"replaced by a new {new.kind.value}"
        assert old.ended == robot.time
        assert robot.running(new.kind) is new

    def test_driving_and_turning_share_the_base(self, robot: Robot) -> None:
        drive = COMMANDS["go_to"](robot)
        turn = COMMANDS["turn_to"](robot)
        assert drive.status is CommandStatus.CANCELLED
        assert turn.running
        assert robot.running(CommandKind.GO_TO) is None

    def test_channels_do_not_disturb_each_other(self, robot: Robot) -> None:
        commands = [issue(robot) for name, issue in COMMANDS.items() if name != "turn_to"]
        assert len({CHANNELS[c.kind] for c in commands}) == 5
        assert all(c.running for c in commands)
        commands[-1].cancel()
        assert all(c.running for c in commands[:-1])

    @each_command
    def test_cancel_can_be_repeated(self, robot: Robot, issue: Callable[[Robot], Command]) -> None:
        command = issue(robot)
        robot.update(robot.time + 0.05)
        command.cancel("changed my mind")
        first = state(command)
        robot.update(robot.time + 0.05)
        command.cancel("again")
        assert state(command) == first
        assert (command.status, command.reason) == (CommandStatus.CANCELLED, "changed my mind")

    @each_command
    def test_an_ended_command_never_changes(
        self, robot: Robot, issue: Callable[[Robot], Command]
    ) -> None:
        command = issue(robot)
        run_until_ended(robot, command)
        first = state(command)
        command.cancel()
        robot.succeed(command)
        robot.fail(command, "too late")
        robot.hear(command)
        issue(robot)
        robot.stop()
        robot.update(robot.time + 1.0)
        assert state(command) == first

    def test_stop_cancels_everything_and_then_succeeds(self, robot: Robot) -> None:
        commands = [issue(robot) for name, issue in COMMANDS.items() if name != "turn_to"]
        robot.update(robot.time + 0.3)
        stop = robot.stop()
        assert not any(c.running for c in commands)
        assert {c.reason for c in commands if c.status is CommandStatus.CANCELLED} == {"stopped"}
        run_until_ended(robot, stop)
        assert stop.status is CommandStatus.SUCCEEDED
        rest = robot.pose
        robot.update(robot.time + 1.0)
        assert robot.pose.distance_to(rest) < 1e-3

    def test_a_new_command_replaces_a_running_stop(self, robot: Robot) -> None:
        COMMANDS["go_to"](robot)
        robot.update(robot.time + 0.3)
        stop = robot.stop()
        drive = COMMANDS["go_to"](robot)
        assert not stop.running
        run_until_ended(robot, drive)
        assert drive.status is CommandStatus.SUCCEEDED

    def test_the_log_keeps_the_order_of_issue(self, robot: Robot) -> None:
        commands = [issue(robot) for issue in COMMANDS.values()]
        robot.update(robot.time + 0.1)
        commands.append(robot.stop())
        assert robot.log == commands
        assert [c.issued for c in robot.log] == sorted(c.issued for c in robot.log)

    def test_unknown_names_are_answered_with_the_valid_ones(self, robot: Robot) -> None:
        with pytest.raises(UnknownNameError, match=r"'wawe'.*wave.*did you mean 'wave'"):
            robot.gesture("wawe")
        with pytest.raises(UnknownNameError, match=r"expression 'smirk'.*neutral, smile"):
            robot.express("smirk")
        assert robot.log == []

    @pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
    def test_numbers_that_are_not_finite_are_refused(self, robot: Robot, bad: float) -> None:
        for call in (
            lambda: robot.go_to(Pose2D(0.0, bad, 0.0)),
            lambda: robot.go_to(Pose2D(0.0, 0.0, bad)),
            lambda: robot.turn_to(bad),
            lambda: robot.look_at((bad, 0.0, 1.0)),
            lambda: robot.express("smile", bad),
            lambda: robot.update(bad),
        ):
            with pytest.raises(ParameterError, match=str(bad)):
                call()
        assert robot.log == []

    def test_other_bad_arguments_are_refused(self, robot: Robot) -> None:
        with pytest.raises(ParameterError, match="empty"):
            robot.say("  ")
        with pytest.raises(ParameterError, match=r"between 0 and 1, not 1\.5"):
            robot.express("smile", 1.5)
        with pytest.raises(ParameterError, match="x, y and z"):
            robot.look_at((1.0, 2.0))  # type: ignore[arg-type]

    def test_the_clock_runs_forward(self, robot: Robot) -> None:
        robot.update(robot.time + 1.0)
        now = robot.time
        with pytest.raises(ParameterError, match="runs forward"):
            robot.update(now - 0.1)
        assert robot.time == now
        robot.update(now)  # standing still is allowed

    @each_command
    def test_a_refused_command_fails_with_the_reason(
        self, robot: Robot, issue: Callable[[Robot], Command], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def refuse(command: Command) -> dict[str, Any]:
            raise RobotError("the motors are off")

        monkeypatch.setattr(robot, "_send", refuse)
        command = issue(robot)
        assert (command.status, command.reason) == (CommandStatus.FAILED, "the motors are off")
        assert robot.running(command.kind) is None
        assert robot.log == [command]

    @each_command
    def test_a_robot_that_stops_answering_fails_the_command(
        self, robot: Robot, issue: Callable[[Robot], Command], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        silent = issue(robot)
        other = COMMANDS["say" if silent.kind is not CommandKind.SAY else "gesture"](robot)
        told: list[Command] = []

        def advance(dt: float) -> None:
            robot.hear(other)

        monkeypatch.setattr(robot, "_advance", advance)
        monkeypatch.setattr(robot, "_abort", told.append)
        robot.update(robot.time + robot.patience)
        assert silent.running
        robot.update(robot.time + 0.1)
        assert silent.status is CommandStatus.FAILED
        assert silent.reason == f"the robot has not answered for {robot.patience:g} s"
        assert told == [silent]
        assert other.running

    @each_command
    def test_a_robot_that_cannot_be_told_to_stop_still_loses_the_command(
        self, robot: Robot, issue: Callable[[Robot], Command], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def deaf(command: Command) -> None:
            raise RobotError("no connection")

        command = issue(robot)
        other = COMMANDS["say" if command.kind is not CommandKind.SAY else "gesture"](robot)
        monkeypatch.setattr(robot, "_abort", deaf)
        robot.stop()
        assert command.status is other.status is CommandStatus.CANCELLED
        assert command.reason == "stopped; the robot could not be told: no connection"

    def test_patience_is_positive(self, robot: Robot) -> None:
        for bad in (0.0, -1.0, math.nan):
            with pytest.raises(ParameterError, match="positive number of seconds"):
                type(robot)(patience=bad)
