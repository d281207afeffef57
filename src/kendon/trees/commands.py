"""Leaves that command the robot, each command once.

The tree is ticked ten times a second and most of its nodes start over when they have succeeded.
So every leaf here remembers the command it sent and sends another only for a reason: the goal
has moved by more than a tolerance, the leaf's round is a new one (Speak), the posture asked for
is not the last one asked for (HOME, expressions), or a failed command's pause is over.

The memory outlives SUCCESS and FAILURE, and ends when the leaf is halted: then a command that
still runs is cancelled, unless it is a gesture. A parent that merely starts over resets its
children, which is not a halt (see `kendon.trees.control`).
"""

from __future__ import annotations

import math
from typing import Any

from py_trees.common import Status

from kendon.geometry import Pose2D, Vec3, wrap_angle
from kendon.robots.base import Command, CommandStatus
from kendon.trees.control import FAILURE, RUNNING, SUCCESS
from kendon.trees.leaves import Leaf
from kendon.trees.ports import BoundPorts
from kendon.trees.poses import WORLD_FRAME
from kendon.trees.state import TreeState

#: A leaf whose command failed waits this long before it tries again, lest a robot that refuses
#: is asked ten times a second [s]. Chosen: long enough not to nag, short within a phase.
RETRY_AFTER = 2.0

#: A base goal that moved by less is the same goal; a robot this near is there [m], [rad].
GOAL_TOLERANCE = 0.1
GOAL_ANGLE_TOLERANCE = 0.1

#: A head that has reached its point looks again when the point's bearing, seen from the base,
#: has turned by more than this since [rad]: the base moved under it. 0.1 rad is a fifth of the
#: half angle of the 60 degree gaze cone (thesis 3.3.3).
BEARING_TOLERANCE = 0.1


class CommandLeaf(Leaf):
    """The base of all leaves that command the robot."""

    #: Ends of a command after which the leaf pauses. A continued command that somebody else
    #: cancelled (an operator's stop) pauses too; one that belongs to a round is simply over.
    pauses_after: tuple[CommandStatus, ...] = (CommandStatus.FAILED, CommandStatus.CANCELLED)

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self.command: Command | None = None
        self._failed: Command | None = None  # the failure the pause is about
        self._retry_at = -math.inf  # [s]

    def terminate(self, new_status: Status) -> None:
        """Cancel what still runs and forget everything; called when the leaf is halted."""
        if new_status is Status.INVALID:
            if self.command is not None:
                self.command.cancel(f"{self.name} was halted")
            self.command = self._failed = None
            self._retry_at = -math.inf

    def waiting(self) -> bool:
        """Whether the last command failed and the pause after it is not over."""
        command = self.command
        if command is None or command.status not in self.pauses_after:
            return False
        if self._failed is not command:
            self._failed = command
            self._retry_at = self.state.t + RETRY_AFTER
        self.feedback_message = f"{command} {command.status.value}: {command.reason}"
        return self.state.t < self._retry_at - 5e-4

    def follow(self) -> Status:
        """The status of the running or ended command, with its reason."""
        command = self.command
        if command is None:
            return FAILURE
        if command.running:
            return RUNNING
        if command.status is CommandStatus.SUCCEEDED:
            return SUCCESS
        self.waiting()
        self.feedback_message = f"{command} {command.status.value}: {command.reason}"
        return FAILURE

    @property
    def active(self) -> bool:
        """Whether a command runs or has succeeded."""
        return self.command is not None and self.command.status in _GOOD


_GOOD = (CommandStatus.RUNNING, CommandStatus.SUCCEEDED)


class MoveBase(CommandLeaf):
    """Drives the base to a goal; turns on the spot when the goal is where the robot stands.

    A goal that moved by less than `GOAL_TOLERANCE` and `GOAL_ANGLE_TOLERANCE` is not sent again,
    and a robot that already stands there gets no command.
    """

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._pose, self._frame = ports.input("goal_pose"), ports.input("frame_id")
        self._goal: Pose2D | None = None  # the one last sent

    def update(self) -> Status:
        """Send a goal that is new, else report on the last."""
        if self.waiting():
            return FAILURE
        robot = self.state.robot
        here = robot.pose
        pose = self._pose.get().in_world(here, self._frame.get() or WORLD_FRAME)
        yaw = pose.yaw
        # A goal without a heading is a place only: the heading may stay.
        goal = Pose2D(pose.position[0], pose.position[1], yaw if yaw == yaw else here.yaw)
        if self.active and self._goal is not None and _near(goal, self._goal):
            return self.follow()
        if _near(goal, here) and not (self.command is not None and self.command.running):
            self.feedback_message = "already there"
            return SUCCESS
        self._goal = goal
        if goal.distance_to(here) <= GOAL_TOLERANCE:
            self.command = robot.turn_to(goal.yaw)
        else:
            self.command = robot.go_to(goal)
        return self.follow()


def _near(a: Pose2D, b: Pose2D) -> bool:
    return (
        math.hypot(a.x - b.x, a.y - b.y) <= GOAL_TOLERANCE
        and abs(wrap_angle(a.yaw - b.yaw)) <= GOAL_ANGLE_TOLERANCE
    )


class GazeAtTarget(CommandLeaf):
    """Turns the face to a point; looks again when the point or the base has moved."""

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._pose, self._frame = ports.input("fixation_pose"), ports.input("frame_id")
        self._tolerance = ports.input("fixation_point_error_tolerance")
        self._point: Vec3 | None = None  # in the world, the one last sent
        self._bearing: Vec3 = (0.0, 0.0, 0.0)  # unit vector in the base frame, when last sent

    def update(self) -> Status:
        """Send a point that is new, else report on the last."""
        if self.waiting():
            return FAILURE
        robot = self.state.robot
        pose = robot.pose
        point = self._pose.get().in_world(pose, self._frame.get() or WORLD_FRAME).position
        if self.active and self._point is not None:
            moved = math.dist(point, self._point) > self._tolerance.get()
            if not moved and not self._turned_away(point, pose):
                return self.follow()
        self._point, self._bearing = point, _bearing(pose.to_local(point), robot.face)
        self.command = robot.look_at(point)
        return self.follow()

    def _turned_away(self, point: Vec3, pose: Pose2D) -> bool:
        # While the command runs, the robot itself brings its face to the point.
        if self.command is not None and self.command.running:
            return False
        now = _bearing(pose.to_local(point), self.state.robot.face)
        return math.dist(now, self._bearing) > BEARING_TOLERANCE  # chord for angle


def _bearing(point: Vec3, face: Vec3) -> Vec3:
    x, y, z = point[0] - face[0], point[1] - face[1], point[2] - face[2]
    norm = math.sqrt(x * x + y * y + z * z) or 1.0
    return (x / norm, y / norm, z / norm)


class ArmRoutines(CommandLeaf):
    """Starts a gesture; SUCCESS as soon as the robot performs it (thesis 4.1.2).

    HOME and ARMS_DOWN are postures: asked for again while the tree's last gesture was the same
    and has not failed, nothing is sent; nor is it while another gesture is being performed: that
    is let finish, and a posture that is still asked for then follows. Any other gesture replaces
    the one before, and is started anew in every round.

    A halt does not end a gesture that has begun. In BehaviorTree.CPP nothing could, since the
    leaf has completed; and phases change within a second, in which a wave would be cut short.
    """

    postures = ("home", "arms_down")
    pauses_after = (CommandStatus.FAILED,)

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._gesture = ports.input("gesture")

    def update(self) -> Status:
        """Start the gesture."""
        if self.waiting():
            return FAILURE
        name, last = self._gesture.get(), self.state.arms
        performing = last is not None and last.running
        if name in self.postures:
            if _still_holds(last, name=name):
                return SUCCESS
            if performing:
                self.feedback_message = f"{last} is let finish"
                return SUCCESS
        elif performing and self.command is None and _still_holds(last, name=name):
            self.command = last  # back in the phase that began it
            return SUCCESS
        self.command = self.state.arms = self.state.robot.gesture(name)
        return _started(self)

    def terminate(self, new_status: Status) -> None:
        """Forget the gesture, but let it finish; called when the leaf is halted."""
        if new_status is Status.INVALID:
            self.command = None
        super().terminate(new_status)


class Express(CommandLeaf):
    """Shows a facial expression; SUCCESS as soon as it begins (thesis 5.2, future work).

    The one that is shown already is not sent again. A robot whose face cannot show it
    does without.
    """

    pauses_after = (CommandStatus.FAILED,)

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._expression, self._intensity = ports.input("expression"), ports.input("intensity")

    def update(self) -> Status:
        """Begin to show the expression."""
        if self.waiting():
            return FAILURE
        robot, last = self.state.robot, self.state.expression
        name, intensity = self._expression.get(), self._intensity.get()
        if name not in robot.expressions:
            self.feedback_message = f"this robot does not show {name!r}"
            return SUCCESS
        if _still_holds(last, expression=name, intensity=intensity):
            return SUCCESS
        self.command = self.state.expression = robot.express(name, intensity)
        return _started(self)


class Speak(CommandLeaf):
    """Says an utterance once a round; RUNNING until it has been said."""

    pauses_after = (CommandStatus.FAILED,)

    def __init__(self, name: str, ports: BoundPorts, state: TreeState) -> None:
        super().__init__(name, ports, state)
        self._utterance, self._language = ports.input("utterance"), ports.input("language")

    def update(self) -> Status:
        """Begin to speak, or report on it."""
        if self.status is RUNNING:
            return self.follow()
        if self.waiting():
            return FAILURE
        self.command = self.state.robot.say(self._utterance.get(), self._language.get())
        return self.follow()


def _still_holds(last: Command | None, **asked: Any) -> bool:
    return last is not None and last.status in _GOOD and last.asked == asked


def _started(leaf: CommandLeaf) -> Status:
    return SUCCESS if leaf.active else leaf.follow()
