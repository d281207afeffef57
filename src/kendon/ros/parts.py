"""The parts of a node: reading the phases, answering them, or both in one flow.

A part is fed with frames and states as they come and with the time when none do, and yields what
there is to tell. It knows nothing of ROS.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from kendon.geometry import Vec3
from kendon.greeter import FORGOTTEN, REMEMBERED, Flow, Moment
from kendon.models import load_model
from kendon.person import PersonFrame
from kendon.phases import Phase
from kendon.robots.base import Command, Robot
from kendon.ros.settings import NodeSettings, Part
from kendon.ros.stream import PersonStream
from kendon.trees import TICK_RATE, GreetingTree, TickContext
from kendon.trees.library import TreeLibrary
from kendon.trees.xml import parse_trees

#: How long to wait for the next message until time goes on without it [s]: longer than cameras
#: and networks take, shorter than a person notices.
GRACE = 0.15
#: So many of the robot's commands are remembered.
_LOGGED = 100
#: A state that is not told again for so long holds no more [s]: five intervals.
STATE_HOLDS = 1.0


@dataclass(frozen=True, slots=True)
class Told:
    """What there is to tell after a tick."""

    moment: Moment
    stamp: float  # [s], of the moment's observation, by the clock of the messages


class NodePart(ABC):
    """What a node does with the person of a stream."""

    @abstractmethod
    def frame(self, frame: PersonFrame, now: float) -> Iterator[Told]:
        """What there is to tell up to a frame, which is taken in.

        Args:
            frame: with the stream's time.
            now: when it came, by the node's clock [s].
        """

    @abstractmethod
    def idle(self, now: float) -> Iterator[Told]:
        """What there is to tell although nothing came."""

    @abstractmethod
    def end(self) -> None:
        """Halt the tree, and tell the robot to stop if it was told anything else."""


class ReadingPart(NodePart):
    """Reads the phases; with a robot that answers, the whole flow.

    Args:
        stream: where the frames come from.
        robot: answers.
        settings: what the user said.

    Raises:
        KendonError: the model or the tree of the settings cannot be read.
    """

    def __init__(self, stream: PersonStream, robot: Robot, settings: NodeSettings) -> None:
        self._stream = stream
        self._answers = settings.part is Part.BOTH
        tree = _tree(settings) if self._answers else GreetingTree(_no_answers())
        self._flow = Flow(robot, load_model(settings.model), tree)
        self._first: float | None = None  # the stream's time of the first frame

    def frame(self, frame: PersonFrame, now: float) -> Iterator[Told]:
        """What there is to tell up to a frame, which is taken in."""
        if self._first is None:
            self._first = frame.t
        # The flow's clock begins at zero, that of the robot's commands likewise.
        for moment in self._flow.take(frame._replace(t=frame.t - self._first)):
            yield self._told(moment)

    def idle(self, now: float) -> Iterator[Told]:
        """What there is to tell although nothing came."""
        t = self._stream.at(now)
        if t is not None and self._first is not None:
            for moment in self._flow.advance(t - self._first - GRACE):
                yield self._told(moment)
        self._flow.shorten_log(_LOGGED)

    def end(self) -> None:
        """Halt the tree, and tell the robot to stop, unless another node answers."""
        if self._answers:
            self._flow.end()

    def _told(self, moment: Moment) -> Told:
        t = moment.observation.t if moment.observation else moment.t
        return Told(moment, self._stream.stamp(t + (self._first or 0.0)))


class AnsweringPart(NodePart):
    """Answers the states that another node tells, ten times a second (thesis 4.1.1).

    Args:
        robot: answers.
        settings: what the user said.

    Raises:
        KendonError: the tree of the settings cannot be read, or asks for what the robot has not.
    """

    def __init__(self, robot: Robot, settings: NodeSettings) -> None:
        self.robot = robot
        self.tree = _tree(settings)
        self.tree.require(robot)
        self._start: float | None = None  # [s], the node's clock at the first tick
        self._now = -math.inf
        self._ticks = 0
        self._phase: Phase | None = None
        self._told_at = -math.inf  # [s], when the state came
        self._seen: PersonFrame | None = None
        self._seen_at = -math.inf  # [s]
        self._logged = 0

    def state(self, phase: Phase, now: float) -> None:
        """Take in the state."""
        self._phase, self._told_at = phase, now

    def frame(self, frame: PersonFrame, now: float) -> Iterator[Told]:
        """Take in where the person is; then as if nothing had come."""
        if frame.seen:
            if self._seen is not None and frame.who != self._seen.who:
                self.tree.halt()
            self._seen, self._seen_at = frame, now
        yield from self.idle(now)

    def idle(self, now: float) -> Iterator[Told]:
        """Tick the tree if it is time to."""
        if self._start is None or now < self._now:  # the clock began again
            self._start, self._ticks = now - self.robot.time, round(self.robot.time * TICK_RATE)
            self._told_at, self._seen_at = min(self._told_at, now), min(self._seen_at, now)
        self._now = now
        t = now - self._start
        if t * TICK_RATE < self._ticks:
            return
        # Ticks that were missed are not made up for: the robot is where it is.
        self._ticks = math.floor(t * TICK_RATE) + 1
        yield Told(self._tick(t, now), now)

    def end(self) -> None:
        """Halt the tree, and tell the robot to stop."""
        self.tree.halt()
        self.robot.stop()

    def _tick(self, t: float, now: float) -> Moment:
        if now - self._seen_at > FORGOTTEN and self._seen is not None:
            self._seen = self._phase = None
            self.tree.halt()
        self.robot.update(t)
        person = self._person(now)
        self.robot.person = self._head(person)
        phase = self._phase if now - self._told_at <= STATE_HOLDS else None
        self.tree.tick(TickContext(t, phase, person, self.robot))
        commands: tuple[Command, ...] = tuple(self.robot.log[self._logged :])
        del self.robot.log[:-_LOGGED]
        self._logged = len(self.robot.log)
        # Who only hears of phases knows nothing of intentions.
        return Moment(t, person, None, None, False, self.robot.pose, commands, greets=1.0)

    def _person(self, now: float) -> PersonFrame | None:
        if self._seen is None or now - self._seen_at > REMEMBERED:
            return None
        return self._seen.seen_from(self.robot.pose)

    def _head(self, person: PersonFrame | None) -> Vec3 | None:
        return self.robot.pose.to_world(person.head) if person else None


def make_part(stream: PersonStream, robot: Robot, settings: NodeSettings) -> NodePart:
    """The part that the settings ask for; one that only reads sends the robot no commands.

    Raises:
        KendonError: the model or the tree of the settings cannot be read.
    """
    if settings.part is Part.ANSWERING:
        return AnsweringPart(robot, settings)
    return ReadingPart(stream, robot, settings)


def _no_answers() -> TreeLibrary:
    """A tree that sends no commands."""
    return parse_trees(
        '<root BTCPP_format="4"><BehaviorTree ID="None"><AlwaysSuccess/></BehaviorTree></root>',
        "no answers",
    )


def _tree(settings: NodeSettings) -> GreetingTree:
    return GreetingTree(Path(settings.tree)) if settings.tree else GreetingTree()
