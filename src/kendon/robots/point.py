"""PointRobot: a robot with ideal kinematics, the reference the other robots are held against."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from kendon.errors import RobotError, UnknownNameError
from kendon.geometry import ORIGIN, Pose2D, Vec3
from kendon.robots.base import Command, CommandKind, Robot
from kendon.robots.drive import BaseLimits
from kendon.robots.driving import Driving, check, check_finite
from kendon.robots.head import HeadLimits, PanTiltHead

#: How long each gesture takes [s], arm up to arm down. Chosen: a person's wave and handshake
#: last two to three seconds, and a robot's arm needs about another to come up and go down.
GESTURE_SECONDS: Mapping[str, float] = {
    "home": 1.0,
    "wave": 3.0,
    "handshake": 4.0,
    "stretch": 3.0,
}
#: Unhurried speech: about 150 words a minute of six letters and spaces each [characters/s].
SPEECH_RATE = 15.0
#: How long a face takes to change its expression [s]; chosen, about the onset of a smile.
EXPRESSION_SECONDS = 0.5


class PointRobot(Robot):
    """A unicycle base, a pan-tilt head, and arms, voice and face that take their time.

    What its commands do:

    * **go_to** turns toward the goal, drives, and turns to the goal's yaw, as a curve when
      the goal moves on the way; a goal close behind is reached in reverse. It keeps
      `keep_distance` from `person`: it brakes in time for where a person stands or steadily
      walks, drives around one in the way, and never flees from one who comes near. A goal
      within the keep distance, or off the leash, is moved, and `sent["goal"]` is the one
      that is driven to. When the person walks onto the goal, the command succeeds at the
      edge of their space; when the person bars the way for 5 s, it fails. The `reason` says so.
    * **turn_to** turns in place, also next to a person.
    * **look_at** turns the head until the face points at the point; while it runs, turns of
      the base are made up for, and afterwards the joints keep still. A point beyond the
      joints is looked toward as far as they go: `sent` holds the `pan` and `tilt`, and once
      the base stands the command succeeds with the limit as its `reason`.
    * **gesture**, **say** and **express** end after their durations.
    * **stop** brakes at the limits and succeeds when the base stands.

    Args:
        start: the pose it starts from in the world; the leash is tied there.
        face: its face in the base frame [m]; the default is the height the features assume.
        limits: the base's speeds and accelerations.
        head: the head's ranges and rate.
        keep_distance: how near its centre may drive to the person, ground plane [m]; the
            default is the thesis's distance to greet at (thesis 4.1.2).
        leash: how far its centre may get from the start [m]; 0 only turns, None is free.
        position_tolerance: how near to its goal a drive ends [m]. It aims at the goal itself;
            the tolerance also keeps a base that has arrived from setting out again for every
            jitter of the goal, and the default is half that of move_base.
        yaw_tolerance: likewise for the heading [rad].
        gesture_seconds: durations that replace those of `GESTURE_SECONDS`, by name [s].
        speech_rate: how fast it speaks [characters/s].
        patience: see `Robot`; a PointRobot always answers.

    Raises:
        ParameterError: an argument is out of its range.
        UnknownNameError: gesture_seconds names a gesture that does not exist.

    >>> robot = PointRobot()
    >>> drive = robot.go_to(Pose2D(1.0, 0.0, 0.0))
    >>> robot.update(1.5)  # accelerates for 1 s and 0.25 m, then 0.5 m/s
    >>> round(robot.pose.x, 2), robot.speed
    (0.5, 0.5)
    >>> robot.update(3.1); drive.status.value
    'succeeded'
    """

    def __init__(
        self,
        start: Pose2D = ORIGIN,
        *,
        face: Vec3 = (0.0, 0.0, 1.2),
        limits: BaseLimits | None = None,
        head: HeadLimits | None = None,
        keep_distance: float = 1.0,
        leash: float | None = None,
        position_tolerance: float = 0.05,
        yaw_tolerance: float = 0.02,
        gesture_seconds: Mapping[str, float] | None = None,
        speech_rate: float = SPEECH_RATE,
        patience: float = 5.0,
    ) -> None:
        super().__init__(patience=patience)
        check_finite("face", face, 3, "x, y and z [m]")
        check("speech_rate", speech_rate, "characters/s")
        self._seconds = dict(GESTURE_SECONDS)
        for name, seconds in (gesture_seconds or {}).items():
            if name not in self.gestures:
                raise UnknownNameError("gesture", name, self.gestures)
            check(f"gesture_seconds[{name!r}]", seconds, "s", zero=True)
            self._seconds[name] = seconds
        self._speech_rate = speech_rate
        self._driving = Driving(
            start, limits or BaseLimits(), keep_distance, leash, position_tolerance, yaw_tolerance
        )
        self._base = self._driving.base
        self._pose = Pose2D(self._base.x, self._base.y, self._base.yaw)
        self._head = PanTiltHead((face[0], face[1], face[2]), head or HeadLimits())
        self._until: dict[CommandKind, float] = {}  # [s], when timed commands end
        self._expression, self._level = "neutral", 1.0
        self._ramp = (0.0, 1.0)  # the expression's intensity before and after its change

    # ---- what the robot knows of itself

    @property
    def pose(self) -> Pose2D:
        """The pose of the base in the world."""
        return self._pose

    @property
    def face(self) -> Vec3:
        """The face in the base frame [m]; the head turns about it."""
        return self._head.face

    @property
    def speed(self) -> float:
        """The base's speed, negative in reverse [m/s]."""
        return self._base.speed

    @property
    def turn_rate(self) -> float:
        """The base's turn rate, positive to the left [rad/s]."""
        return self._base.turn_rate

    @property
    def pan(self) -> float:
        """The head's pan, positive to the left of the base's x axis [rad]."""
        return self._head.pan

    @property
    def tilt(self) -> float:
        """The head's tilt, positive up [rad]."""
        return self._head.tilt

    @property
    def gaze_direction(self) -> Vec3:
        """Where the face points in the world, a unit vector."""
        return self._head.direction(self._base.yaw)

    @property
    def expression(self) -> tuple[str, float]:
        """The expression on the face and its present intensity between 0 and 1."""
        return self._expression, self._level

    # ---- the hooks of Robot

    def _send(self, command: Command) -> dict[str, Any]:
        kind, asked = command.kind, command.asked
        sent = dict(asked)
        if kind in (CommandKind.GO_TO, CommandKind.TURN_TO):
            sent = self._driving.send(command, self.person, self.time)
        elif kind is CommandKind.LOOK_AT:
            point: Vec3 = asked["point"]
            self._driving.refuse_far("point to look at", *point)
            if math.dist(self.pose.to_world(self.face), point) < 1e-3:
                raise RobotError(f"the point to look at, {point}, lies in the robot's own face")
            sent["pan"], sent["tilt"], _ = self._head.angles_to(point, self.pose)
        elif kind is CommandKind.GESTURE:
            self._until[kind] = self.time + self._seconds[asked["name"]]
        elif kind is CommandKind.SAY:
            self._until[kind] = self.time + len(asked["text"].strip()) / self._speech_rate
        elif kind is CommandKind.EXPRESS:
            self._until[kind] = self.time + EXPRESSION_SECONDS
            same = asked["expression"] == self._expression
            self._ramp = (self._level if same else 0.0, asked["intensity"])
            self._expression, self._level = asked["expression"], self._ramp[0]
        elif self._base.standing:
            self.succeed(command)
        return sent

    def _abort(self, command: Command) -> None:
        if command.kind in (CommandKind.GO_TO, CommandKind.TURN_TO):
            self._base.aim()

    def _advance(self, dt: float) -> None:
        base = self._base
        self._driving.clearance.observe(self.person, self.time)
        base.advance(dt)
        self._pose = Pose2D(base.x, base.y, base.yaw)
        for channel, command in self._occupied.items():
            if not command.running:
                continue
            command.heard = self.time
            if channel == "base":
                self._driving.finish(self, command)
            elif channel == "head":
                self._look(command, dt)
            elif channel == "all":
                if base.standing:
                    self.succeed(command)
            else:
                left = self._until[command.kind] - self.time
                if channel == "face":
                    old, new = self._ramp
                    self._level = new - (new - old) * max(0.0, left) / EXPRESSION_SECONDS
                if left <= 1e-9:  # a sum of time steps may fall short by rounding
                    self.succeed(command)

    def _look(self, command: Command, dt: float) -> None:
        pan, tilt, reachable = self._head.angles_to(command.asked["point"], self.pose)
        # A base that still turns may yet bring the point within the joints' reach.
        if self._head.turn(pan, tilt, dt) and (reachable or self._base.standing):
            self.succeed(command, "" if reachable else "the point lies beyond the head's joints")
