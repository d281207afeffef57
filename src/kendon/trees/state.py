"""What the nodes of one tree instance share: the world of this tick and the last commands."""

from __future__ import annotations

from dataclasses import dataclass

from kendon.errors import RobotError, TreeError
from kendon.geometry import Vec3
from kendon.person import PersonFrame
from kendon.phases import Phase
from kendon.robots.base import Command, Robot
from kendon.trees.poses import BASE_FRAME, Pose


@dataclass(slots=True)
class TickContext:
    """Everything one tick of a tree sees.

    Args:
        t: the flow's clock [s].
        phase: the phase the belief holds for the most probable; None while there is none.
        person: the greeted person in the robot's base frame as it stands now; None if nobody is
            seen.
        robot: takes the commands.
        greets: the probability that the person means to greet the robot at all.
    """

    t: float  # [s]
    phase: Phase | None
    person: PersonFrame | None
    robot: Robot
    greets: float = 1.0


class TreeState:
    """One tree instance's view of the world and its memory across nodes."""

    def __init__(self) -> None:
        self.t = 0.0  # [s], the flow's clock
        self.phase: Phase | None = None
        self.greets = 1.0  # the probability that the person means to greet
        self.face: Pose | None = None  # in the world, last seen
        self.face_seen = 0.0  # [s], when
        self.arms: Command | None = None  # the last gesture any leaf of this tree asked for
        self.expression: Command | None = None  # the last expression, likewise
        self._robot: Robot | None = None

    @property
    def robot(self) -> Robot:
        """The robot of this tick.

        Raises:
            TreeError: the tree has not been ticked yet.
        """
        if self._robot is None:
            raise TreeError("the tree has no robot before its first tick")
        return self._robot

    def update(self, context: TickContext) -> None:
        """Take over what this tick sees."""
        self.t, self.phase, self.greets = context.t, context.phase, context.greets
        if context.robot is not self._robot:  # what another robot did says nothing of this one
            self._robot, self.arms, self.expression = context.robot, None, None
        person = context.person
        if person is not None and person.seen:
            robot = context.robot
            x, y, z = person.head
            # A face whose height is unknown is taken to be level with the robot's own.
            head: Vec3 = (x, y, z if z == z else robot.face[2])
            try:
                pose = robot.pose
            except RobotError:  # it does not know where it stands, nor then where the face is
                return
            self.face = Pose(head, person.head_rotation, BASE_FRAME).in_world(pose)
            self.face_seen = context.t

    def forget(self) -> None:
        """End the gesture and forget the person; called when the tree is halted."""
        if self.arms is not None:
            self.arms.cancel("the tree was halted")
        self.phase = None
        self.face = None
