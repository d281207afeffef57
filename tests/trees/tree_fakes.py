"""A robot and leaves that do exactly what a test tells them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from kendon.errors import RobotError
from kendon.geometry import ORIGIN, UNKNOWN_ROTATION, Pose2D, Quaternion, Vec3
from kendon.person import PersonFrame
from kendon.phases import Phase
from kendon.robots.base import Command, CommandKind, Robot
from kendon.trees import GreetingTree, TickContext, parse_trees

STATUS = {"S": Status.SUCCESS, "F": Status.FAILURE, "R": Status.RUNNING, "K": Status.INVALID}


class ScriptedLeaf(Behaviour):
    """Answers the letters of a script tick by tick (the last for ever) and counts."""

    def __init__(self, script: str) -> None:
        super().__init__(script)
        self.script, self.ticks, self.halts = script, 0, 0

    def update(self) -> Status:
        self.ticks += 1
        return STATUS[self.script[min(self.ticks, len(self.script)) - 1]]

    def terminate(self, new_status: Status) -> None:
        # The call may reach a leaf that is idle; only an active one has something to halt.
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self.halts += 1


def scripted(scripts: Sequence[str]) -> list[ScriptedLeaf]:
    return [ScriptedLeaf(script) for script in scripts]


class TeleportRobot(Robot):
    """Carries out every command `delay` seconds after it was asked, all at once."""

    def __init__(self, delay: float = 0.5, *, mute: Sequence[CommandKind] = ()) -> None:
        super().__init__()
        self.delay = delay
        self.mute = tuple(mute)  # kinds it takes and never answers
        self.refuses: tuple[CommandKind, ...] = ()
        self.aborted: list[Command] = []
        self.place = ORIGIN

    @property
    def pose(self) -> Pose2D:
        return self.place

    @property
    def face(self) -> Vec3:
        return (0.0, 0.0, 1.2)

    def _send(self, command: Command) -> dict[str, Any]:
        if command.kind in self.refuses:
            raise RobotError(f"no {command.kind.value} today")
        return dict(command.asked)

    def _abort(self, command: Command) -> None:
        self.aborted.append(command)

    def _advance(self, dt: float) -> None:
        for command in list(self._occupied.values()):
            if command.kind in self.mute or not command.running:
                continue
            self.hear(command)
            if self.time - command.issued >= self.delay - 1e-9:
                if command.kind is CommandKind.GO_TO:
                    self.place = command.asked["goal"]
                elif command.kind is CommandKind.TURN_TO:
                    self.place = self.place._replace(yaw=command.asked["yaw"])
                self.succeed(command)


class Stage:
    """A tree, a robot and a person who stands in the world."""

    def __init__(self, tree: GreetingTree | str | None = None, robot: Robot | None = None) -> None:
        if isinstance(tree, str):
            tree = one_tree(tree)
        self.tree = tree or GreetingTree()
        self.robot = robot or TeleportRobot()
        self.t = 0.0
        self.ticks = 0
        self.face: Vec3 | None = (4.0, 1.0, 1.7)
        self.rotation: Quaternion = UNKNOWN_ROTATION

    def person(self) -> PersonFrame | None:
        if self.face is None:
            return None
        return PersonFrame(self.t, head=self.face, head_rotation=self.rotation).seen_from(
            self.robot.pose
        )

    def run(self, phase: Phase | None, seconds: float = 0.1) -> Status:
        status = Status.INVALID
        for _ in range(max(1, round(seconds * 10))):
            self.ticks += 1
            self.t = self.ticks / 10
            self.robot.update(self.t)
            person = self.person()
            status = self.tree.tick(TickContext(self.t, phase, person, self.robot))
        return status

    def sent(self, kind: CommandKind | None = None) -> list[Command]:
        return [c for c in self.robot.log if kind is None or c.kind is kind]

    def message(self, kind: str) -> str:
        return next(s.message for s in self.tree.states() if s.kind == kind)

    def status(self, kind: str) -> str:
        return next(s.status for s in self.tree.states() if s.kind == kind)


def xml(body: str, extra: str = "") -> str:
    return (
        f'<root BTCPP_format="4" main_tree_to_execute="Main"><BehaviorTree ID="Main">{body}'
        f"</BehaviorTree>{extra}</root>"
    )


def one_tree(body: str, extra: str = "") -> GreetingTree:
    return GreetingTree(parse_trees(xml(body, extra)))


def close(a: Pose2D, b: Pose2D, tolerance: float = 1e-9) -> bool:
    turn = math.remainder(a.yaw - b.yaw, 2 * math.pi)
    return math.hypot(a.x - b.x, a.y - b.y) < tolerance and abs(turn) < tolerance
