"""The commands that move a base, `go_to` and `turn_to`, for robots that kendon itself drives."""

from __future__ import annotations

import math
from typing import Any

from kendon.errors import ParameterError, RobotError
from kendon.geometry import Pose2D, Vec3
from kendon.robots.base import Command, CommandKind, Robot
from kendon.robots.clearance import Clearance
from kendon.robots.drive import BaseLimits, UnicycleBase

#: How long a base waits before a person who stands in its way, until it gives up [s].
BLOCKED_SECONDS = 5.0
#: Points farther away than this are taken for a mistake in the units or the frame [m].
FARTHEST = 1000.0


class Driving:
    """Drives a `UnicycleBase` to what commands ask, away from the person and on its leash.

    Args:
        start: the pose it starts from in the world; the leash is tied there.
        limits: the base's speeds and accelerations.
        keep_distance: how near its centre may drive to the person, ground plane [m].
        leash: how far its centre may get from the start [m]; 0 only turns, None is free.
        position_tolerance: how near to its goal a drive ends [m].
        yaw_tolerance: likewise for the heading [rad].

    Raises:
        ParameterError: an argument is out of its range.
    """

    def __init__(
        self,
        start: Pose2D,
        limits: BaseLimits,
        keep_distance: float,
        leash: float | None,
        position_tolerance: float,
        yaw_tolerance: float,
    ) -> None:
        check_finite("start", start, 3, "x, y [m] and yaw [rad]")
        check("keep_distance", keep_distance, "m", zero=True)
        if leash is not None:
            check("leash", leash, "m", zero=True)
        check("position_tolerance", position_tolerance, "m")
        check("yaw_tolerance", yaw_tolerance, "rad")
        self.clearance = Clearance(keep_distance, Pose2D(*start), leash)
        self.base = UnicycleBase(
            Pose2D(*start), limits, self.clearance, position_tolerance, yaw_tolerance
        )
        self._moved_goal = ""  # why the goal being driven to is not the one asked for

    def send(self, command: Command, person: Vec3 | None, t: float) -> dict[str, Any]:
        """Set out; what was really sent.

        Args:
            command: a `go_to` or `turn_to`.
            person: the greeted person's face in the world.
            t: the time [s].

        Raises:
            RobotError: the goal is too far away to be meant.
        """
        sent = dict(command.asked)
        if command.kind is CommandKind.TURN_TO:
            self.base.aim(heading=sent["yaw"])
            return sent
        goal: Pose2D = sent["goal"]
        self.refuse_far("goal", goal.x, goal.y)
        self.clearance.observe(person, t)
        goal, self._moved_goal = self.clearance.clip(self.base.x, self.base.y, goal)
        self.base.aim(goal=goal)
        sent["goal"] = goal
        return sent

    def finish(self, robot: Robot, command: Command) -> None:
        """End the robot's drive or turn if it has arrived or can get no farther."""
        if self.base.arrived:
            self.arrive(robot, command)
        elif self.base.blocked >= BLOCKED_SECONDS:
            self.base.aim()
            robot.fail(command, f"the person has barred the way for {BLOCKED_SECONDS:g} s")

    def arrive(self, robot: Robot, command: Command) -> None:
        """End the robot's drive or turn where it is: as done, and with what fell short of it."""
        base = self.base
        reason = self._moved_goal if command.kind is CommandKind.GO_TO else ""
        if base.off_goal > base.position_tolerance:
            reason = f"the person has come within {self.clearance.keep:g} m of the goal"
        base.aim()
        robot.succeed(command, reason)

    def refuse_far(self, what: str, x: float, y: float, z: float = 0.0) -> None:
        """Refuse a point that is too far away to be meant.

        Raises:
            RobotError: it is.
        """
        if not math.dist((self.base.x, self.base.y, 0.0), (x, y, z)) <= FARTHEST:
            raise RobotError(
                f"the {what} at x = {x:g} m, y = {y:g} m is farther than {FARTHEST:g} m away"
            )


def check(name: str, value: float, unit: str, *, zero: bool = False) -> None:
    """Refuse a number that is not finite and positive (or zero where that is allowed).

    Raises:
        ParameterError: it is not.
    """
    if not (math.isfinite(value) and (value >= 0 if zero else value > 0)):
        least = "at least 0" if zero else "more than 0"
        raise ParameterError(f"{name} is a finite number of {unit}, {least}, not {value}")


def check_finite(name: str, values: tuple[float, ...], count: int, meaning: str) -> None:
    """Refuse values that are not so many finite numbers.

    Raises:
        ParameterError: they are not.
    """
    if len(values) != count or not all(math.isfinite(v) for v in values):
        raise ParameterError(f"{name} needs {count} finite numbers, {meaning}, not {values}")
