"""The contract of a robot: non-blocking commands that return a handle with status and cancel."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, NamedTuple

from kendon.errors import ParameterError, RobotError, UnknownNameError
from kendon.geometry import Pose2D, Vec3, wrap_angle


class CommandKind(Enum):
    """What a command asks for; the value is its name in logs."""

    GO_TO = "go_to"
    TURN_TO = "turn_to"
    LOOK_AT = "look_at"
    GESTURE = "gesture"
    SAY = "say"
    EXPRESS = "express"
    STOP = "stop"


class CommandStatus(Enum):
    """Where a command stands."""

    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"


#: To ask an Enum for its member takes Python 3.11 ten times as long as to read a name, and
#: every tick of a tree asks several times whether a command runs.
_RUNNING = CommandStatus.RUNNING

#: The part of the body a command occupies: a new command replaces the one that is there.
CHANNELS: dict[CommandKind, str] = {
    CommandKind.GO_TO: "base",
    CommandKind.TURN_TO: "base",
    CommandKind.LOOK_AT: "head",
    CommandKind.GESTURE: "arms",
    CommandKind.SAY: "voice",
    CommandKind.EXPRESS: "face",
    CommandKind.STOP: "all",
}


class Appearance(NamedTuple):
    """What somebody who looks at a robot sees and hears of it."""

    t: float  # [s], the robot's clock
    pose: Pose2D  # of the base in the world
    face: Vec3  # in the world [m]
    gaze: Vec3  # where the face points in the world, a unit vector
    gesture: str | None  # being performed; None = the arms rest
    speech: str | None  # being spoken; None = silent
    expression: tuple[str, float] | None  # on the face, with its intensity; None = it has none

    def looks_at(self, point: Vec3) -> float:
        """The angle between where the face points and a point in the world [rad].

        NaN where the point is unknown.
        """
        way = [there - here for there, here in zip(point, self.face, strict=True)]
        length = math.hypot(*way) or 1.0
        cosine = sum(a * b for a, b in zip(way, self.gaze, strict=True)) / length
        return math.acos(min(max(cosine, -1.0), 1.0))  # in this order NaN stays NaN


@dataclass(eq=False)
class Command:
    """The handle of one command: what was asked, what was really sent, and how it goes.

    A command that has ended never changes again.
    """

    kind: CommandKind
    asked: dict[str, Any]
    issued: float  # [s], the robot's clock
    robot: Robot = field(repr=False)
    sent: dict[str, Any] = field(default_factory=dict)  # `asked` after the robot's limits
    status: CommandStatus = CommandStatus.RUNNING
    ended: float = math.nan  # [s]
    reason: str = ""  # why it failed, was cancelled, or fell short of what was asked; one clause
    heard: float = math.nan  # [s], when the robot last gave a sign of life about it

    @property
    def running(self) -> bool:
        """Whether the command is still being carried out."""
        return self.status is _RUNNING

    def cancel(self, reason: str = "cancelled") -> None:
        """Tell the robot to stop doing this; does nothing when the command has ended.

        The command ends as cancelled even if the robot cannot be told; `reason` then says so.
        """
        if self.running:
            trouble = self.robot._try_abort(self)
            self._end(CommandStatus.CANCELLED, f"{reason}; {trouble}" if trouble else reason)

    def _end(self, status: CommandStatus, reason: str = "") -> None:
        if self.running:
            self.status, self.reason, self.ended = status, reason, self.robot.time

    def __str__(self) -> str:
        shown = ", ".join(f"{_show(v)}" for v in (self.sent or self.asked).values())
        return f"{self.kind.value}({shown})"


def _show(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.2f}"
    if isinstance(value, tuple):
        return "(" + ", ".join(_show(v) for v in value) + ")"
    return str(value)


class Robot(ABC):
    """A robot that can greet. Subclasses fill in the hooks; users call the commands.

    Every command returns at once with a handle. A new command on an occupied channel (base,
    head, arms, voice, face) replaces the old one, whose handle ends as cancelled; any new
    command replaces a running `stop`. Positions are in the world frame (``map``), metres and
    radians.

    Hooks, and how long each may take:
        `_send`: once a command, before it is logged. Must not block (at most a few ms).
        `_abort`: when a running command is cancelled, replaced, or failed because the robot
            did not answer. Must not block.
        `_advance`: at every `update`. Must not block. Ends commands with `succeed` and
            `fail`, and calls `hear` for those it got a sign of life from.

    Args:
        patience: how long a command may run without a sign of life from the robot before it
            is failed [s].

    Raises:
        ParameterError: patience is not positive.
    """

    #: The gestures this robot performs.
    gestures: tuple[str, ...] = ("home", "wave", "handshake", "stretch")
    #: The expressions this robot shows.
    expressions: tuple[str, ...] = ("neutral", "smile")

    def __init__(self, *, patience: float = 5.0) -> None:
        if not patience > 0:
            raise ParameterError(f"patience must be a positive number of seconds, not {patience}")
        self.patience = patience
        self.time = 0.0  # [s], the clock of the last update
        self.log: list[Command] = []
        self.person: Vec3 | None = None  # the greeted person's face in the world, None if lost
        self._occupied: dict[str, Command] = {}

    # ---- what the robot knows of itself

    @property
    @abstractmethod
    def pose(self) -> Pose2D:
        """The pose of the base in the world."""

    @property
    @abstractmethod
    def face(self) -> Vec3:
        """The robot's face in its base frame while it is at rest [m]; this never changes."""

    @property
    def gaze_direction(self) -> Vec3:
        """Where the face points in the world, a unit vector: ahead, if the head cannot turn."""
        yaw = self.pose.yaw
        return (math.cos(yaw), math.sin(yaw), 0.0)

    @property
    def expression(self) -> tuple[str, float] | None:
        """The expression on the face and its intensity, 0 to 1; None for a face without any."""
        return None

    @property
    def performing(self) -> str | None:
        """The gesture being performed, None if the arms rest."""
        command = self.running(CommandKind.GESTURE)
        return None if command is None else str(command.asked["name"])

    @property
    def saying(self) -> str | None:
        """The text being spoken, None if silent."""
        command = self.running(CommandKind.SAY)
        return None if command is None else str(command.asked["text"])

    @property
    def appearance(self) -> Appearance:
        """What a person who looks at the robot sees and hears of it now."""
        pose = self.pose
        return Appearance(
            self.time, pose, pose.to_world(self.face), self.gaze_direction, self.performing,
            self.saying, self.expression,
        )  # fmt: skip

    # ---- commands

    def go_to(self, goal: Pose2D) -> Command:
        """Drive the base to a pose in the world."""
        _require_finite("go_to", *goal)
        return self._issue(CommandKind.GO_TO, goal=Pose2D(goal.x, goal.y, wrap_angle(goal.yaw)))

    def turn_to(self, yaw: float) -> Command:
        """Turn the base in place to a heading in the world [rad]."""
        _require_finite("turn_to", yaw)
        return self._issue(CommandKind.TURN_TO, yaw=wrap_angle(yaw))

    def look_at(self, point: Vec3) -> Command:
        """Turn the head so that the face points at a point in the world [m].

        The command succeeds when it does; the head then holds still. Who wants it to follow
        something looks again when that has moved.
        """
        _require_finite("look_at", *point)
        if len(point) != 3:
            raise ParameterError(f"look_at needs x, y and z, not {tuple(point)}")
        return self._issue(CommandKind.LOOK_AT, point=(point[0], point[1], point[2]))

    def gesture(self, name: str) -> Command:
        """Perform an arm gesture by its name.

        Raises:
            UnknownNameError: the robot has no such gesture.
        """
        if name not in self.gestures:
            raise UnknownNameError("gesture", name, self.gestures)
        return self._issue(CommandKind.GESTURE, name=name)

    def say(self, text: str, language: str = "en") -> Command:
        """Speak a text aloud; `language` is a BCP 47 tag.

        Raises:
            ParameterError: the text is empty.
        """
        if not text.strip():
            raise ParameterError("say needs a text; an empty one was given")
        return self._issue(CommandKind.SAY, text=text, language=language)

    def express(self, expression: str, intensity: float = 1.0) -> Command:
        """Show a facial expression with an intensity between 0 and 1.

        Raises:
            UnknownNameError: the robot has no such expression.
            ParameterError: the intensity is out of range.
        """
        if expression not in self.expressions:
            raise UnknownNameError("expression", expression, self.expressions)
        if not 0 <= intensity <= 1:
            raise ParameterError(f"an expression's intensity is between 0 and 1, not {intensity}")
        return self._issue(CommandKind.EXPRESS, expression=expression, intensity=intensity)

    def stop(self) -> Command:
        """Cancel everything and hold still."""
        for command in list(self._occupied.values()):
            command.cancel("stopped")
        return self._issue(CommandKind.STOP)

    # ---- time

    def update(self, t: float) -> None:
        """Let the robot's clock reach `t` [s]: move, finish commands, fail those unheard of.

        Raises:
            ParameterError: t is not finite or lies before the last update.
        """
        if not math.isfinite(t) or t < self.time:
            raise ParameterError(
                f"a robot's clock runs forward: update({t}) came after {self.time}"
            )
        dt, self.time = t - self.time, t
        self._advance(dt)
        for command in list(self._occupied.values()):
            if t - command.heard > self.patience and command.running:
                # It may be deaf in one direction only: tell it to stop all the same.
                self._try_abort(command)
                self.fail(command, f"the robot has not answered for {self.patience:g} s")
            if not command.running:
                self._release(command)

    # ---- for subclasses

    @abstractmethod
    def _send(self, command: Command) -> dict[str, Any]:
        """Start carrying out a command; return what was really sent, within the limits.

        Raises:
            RobotError: the robot refuses; the command then ends as failed with that reason.
        """

    @abstractmethod
    def _abort(self, command: Command) -> None:
        """Stop carrying out a command that is running.

        Raises:
            RobotError: the robot cannot be told; the command ends all the same.
        """

    @abstractmethod
    def _advance(self, dt: float) -> None:
        """Let `dt` seconds pass; `self.time` is already the new time."""

    def succeed(self, command: Command, reason: str = "") -> None:
        """End a running command as done; `reason` tells what fell short of it, one clause."""
        command._end(CommandStatus.SUCCEEDED, reason)

    def fail(self, command: Command, reason: str) -> None:
        """End a running command as failed, for a reason given in one clause."""
        command._end(CommandStatus.FAILED, reason)

    def hear(self, command: Command) -> None:
        """Note a sign of life about a running command."""
        if command.running:
            command.heard = self.time

    def running(self, kind: CommandKind) -> Command | None:
        """The running command of a kind, if there is one."""
        command = self._occupied.get(CHANNELS[kind])
        return command if command and command.running and command.kind is kind else None

    def _issue(self, kind: CommandKind, **asked: Any) -> Command:
        channel = CHANNELS[kind]
        for occupied in (channel, CHANNELS[CommandKind.STOP]):
            if old := self._occupied.get(occupied):
                old.cancel(f"replaced by a new {kind.value}")
                self._release(old)
        command = Command(kind, asked, issued=self.time, robot=self, heard=self.time)
        self.log.append(command)
        self._occupied[channel] = command
        try:
            command.sent = self._send(command)
        except RobotError as refusal:
            self.fail(command, str(refusal))
        if not command.running:
            self._release(command)
        return command

    def _try_abort(self, command: Command) -> str:
        """Abort a command; what went wrong in doing so, as one clause, or ""."""
        try:
            self._abort(command)
        except RobotError as trouble:
            return f"the robot could not be told: {trouble}"
        return ""

    def _release(self, command: Command) -> None:
        channel = CHANNELS[command.kind]
        if self._occupied.get(channel) is command:
            del self._occupied[channel]


def _require_finite(what: str, *values: float) -> None:
    if not all(map(math.isfinite, values)):
        raise ParameterError(f"{what} needs finite numbers, not {tuple(values)}")
