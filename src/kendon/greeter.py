"""The main job: one person, one model, one tree and one robot tied together.

    for moment in Greeter(open_source("person.csv")).run():
        print(moment.t, moment.belief.phase)

The flow has a clock of its own that starts at zero with the first frame. Frames are taken in at
their stamps; ten times a second the tree is ticked with the newest belief (thesis 4.1.1), five
times a second there is a new one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kendon.errors import ParameterError
from kendon.features import Sampler
from kendon.features.sampler import TOLERANCE
from kendon.geometry import Pose2D, Vec3
from kendon.models import Belief, GreetingModel, Tracker, load_model
from kendon.models.intent import Intent
from kendon.observations import Observation, Observations
from kendon.person import FloatArray, IntArray, PersonFrame
from kendon.phases import Phase
from kendon.robots import PointRobot, Robot
from kendon.robots.base import CHANNELS, Command, CommandKind
from kendon.sources.base import Source
from kendon.trees import TICK_RATE, GreetingTree, TickContext

#: How long a person who is not seen counts as still standing where they were [s].
REMEMBERED = 0.5
#: How long a person must be out of sight for the greeting to be over [s].
FORGOTTEN = 5.0


class Moment(NamedTuple):
    """What the flow knows at one tick of its clock."""

    t: float  # [s] since the first frame
    person: PersonFrame | None  # in the robot's base frame; None when out of sight
    observation: Observation | None  # the newest one; None before the first
    belief: Belief | None  # the belief after it
    is_new: bool  # whether the observation came with this tick
    robot: Pose2D  # the robot's pose in the world
    commands: tuple[Command, ...]  # sent to the robot at this tick
    greets: float  # the probability that the person means to greet at all


@dataclass(frozen=True, slots=True)
class Action:
    """A command in a log: when it ran, on which part of the body, in answer to which phase."""

    command: Command
    phase: Phase | None

    @property
    def start(self) -> float:
        """When it was sent [s]."""
        return self.command.issued

    @property
    def end(self) -> float:
        """When it ended [s]; when the robot's clock stopped if it never did."""
        return self.command.robot.time if self.command.running else self.command.ended

    @property
    def channel(self) -> str:
        """The part of the body it occupied."""
        return CHANNELS[self.command.kind]

    @property
    def label(self) -> str:
        """The command in a few words, without the numbers that change as it is followed up."""
        return describe(self.command)


def describe(command: Command) -> str:
    """A command in a few words: ``wave``, ``drive``, ``“Pleased to meet you”``."""
    asked = command.asked
    match command.kind:
        case CommandKind.GO_TO:
            return "drive"
        case CommandKind.TURN_TO:
            return "turn"
        case CommandKind.LOOK_AT:
            return f"look {asked['point'][2]:.1f} m high"
        case CommandKind.GESTURE:
            return str(asked["name"])
        case CommandKind.SAY:
            return f"“{asked['text']}”"
        case CommandKind.EXPRESS:
            return str(asked["expression"])
        case CommandKind.STOP:
            return "stop"


class Flow:
    """The main job without its source: frames in, moments out, by the clock of the frames.

    Args:
        robot: answers.
        model: reads the phases; the default model where it is left out.
        tree: chooses the commands; the shipped one where it is left out.

    Raises:
        TreeError: the tree names a gesture or a face that the robot does not have.
    """

    def __init__(
        self, robot: Robot, model: GreetingModel | None = None, tree: GreetingTree | None = None
    ) -> None:
        self.model = model or load_model()
        self.robot = robot
        self.tree = tree or GreetingTree()
        self.tree.require(robot)
        self._sampler = Sampler(self.robot.face)
        self._tracker: Tracker = self.model.tracker()
        self._intent = Intent()
        self._seen: PersonFrame | None = None
        self._seen_at = -math.inf
        self._newest: tuple[Observation, Belief, Phase] | None = None
        self._logged = 0
        self._first = math.nan  # [s], the first frame's stamp
        self._ticks = 0

    def take(self, frame: PersonFrame) -> Iterator[Moment]:
        """Take in a frame, after the moments that come before it.

        Raises:
            ParameterError: its stamp is not finite, or not after the last one's.
        """
        if math.isnan(self._first):
            self._first = frame.t
        # A frame that belongs to an interval comes before the tick at that interval's end.
        before = frame.t - TOLERANCE
        if self._is_due(before):
            yield from self.advance(before)
        self._take_in(frame._replace(t=frame.t - self._first) if self._first else frame)

    def advance(self, t: float) -> Iterator[Moment]:
        """The moments before the frames' clock shows `t` [s]; none before the first frame."""
        while self._is_due(t):
            yield self._next()

    def _is_due(self, t: float) -> bool:
        return (self._ticks + 1) / TICK_RATE < t - self._first

    def end(self) -> None:
        """Halt the tree, and tell the robot to stop."""
        self.tree.halt()
        self.robot.stop()

    def shorten_log(self, newest: int) -> None:
        """Forget all but the newest commands of the robot's log, in a flow without an end."""
        log = self.robot.log
        old = max(0, min(self._logged, len(log) - newest))
        del log[:old]
        self._logged -= old

    def _next(self) -> Moment:
        self._ticks += 1
        return self._tick(self._ticks / TICK_RATE)

    def _take_in(self, frame: PersonFrame) -> None:
        for observation in self._sampler.push(frame.seen_from(self.robot.pose)):
            self._observe(observation)
        if not frame.seen:
            return
        if self._seen is not None and frame.who != self._seen.who:
            self._end_greeting()  # somebody else: a greeting of their own
        self._seen, self._seen_at = frame, frame.t
        x, y, _ = frame.robot.to_world(frame.head)
        self._intent.see(frame.t, x, y)

    def _observe(self, observation: Observation) -> None:
        if self._seen is None:
            return  # a belief about nobody would go from phase to phase by the odds alone
        belief = self._tracker.step(observation)
        self._newest = observation, belief, belief.phase
        self._intent.step(observation, self.robot.pose[:2])

    def _tick(self, t: float) -> Moment:
        before = self._newest
        for fresh in self._sampler.advance(t):
            self._observe(fresh)
        if t - self._seen_at > FORGOTTEN and self._seen is not None:
            self._end_greeting()
        self.robot.update(t)
        person = self._person(t)
        self.robot.person = self.robot.pose.to_world(person.head) if person else None
        observation, belief, phase = self._newest or (None, None, None)
        greets = self._intent.probability
        self.tree.tick(TickContext(t, phase, person, self.robot, greets))
        commands = tuple(self.robot.log[self._logged :])
        self._logged += len(commands)
        return Moment(
            t, person, observation, belief, self._newest is not before, self.robot.pose, commands,
            greets,
        )  # fmt: skip

    def _person(self, t: float) -> PersonFrame | None:
        """The person as seen from where the robot is now, while they count as being there."""
        if self._seen is None or t - self._seen_at > REMEMBERED:
            return None
        return self._seen.seen_from(self.robot.pose)

    def _end_greeting(self) -> None:
        """The person has gone: the next one seen starts a new greeting."""
        self._seen = self._newest = None
        self._tracker.reset()
        self._intent.reset()
        self.tree.halt()


class Greeter(Flow):
    """Lets a robot greet the person of a source.

    Args:
        source: the person.
        model: reads the phases; the default model where it is left out.
        robot: answers; where it is left out a `PointRobot`. It is free to drive toward a person
            who reacts to it, but only turns in place before a recorded one, who would walk into
            it: a recorded person walks up to where the recording's own robot stood.
        tree: chooses the commands; the shipped one where it is left out.
    """

    def __init__(
        self,
        source: Source,
        model: GreetingModel | None = None,
        robot: Robot | None = None,
        tree: GreetingTree | None = None,
    ) -> None:
        self.source = source
        super().__init__(robot or PointRobot(leash=None if source.reacts else 0.0), model, tree)

    def run(self) -> Iterator[Moment]:
        """Run the flow to the source's end, one moment a tick; then stop the robot.

        However it ends (the source runs dry, an error, the caller stops iterating), the tree is
        halted and the robot told to stop.

        Raises:
            DataError: there is something wrong with what the source reads.
        """
        self.source.attach(self.robot)
        try:
            for frame in self.source.frames():
                yield from self.take(frame)
            if not math.isnan(self._first):
                yield self._next()
        finally:
            self.end()


class Encounter:
    """The record of a whole run, for figures and files.

    Args:
        title: names the encounter in figures.
    """

    def __init__(self, title: str = "encounter") -> None:
        self.title = title
        self.moments: list[Moment] = []
        self.actions: list[Action] = []
        self._rows: list[Observation] = []
        self._beliefs: list[FloatArray] = []

    def add(self, moment: Moment) -> None:
        """Take in the next moment of the run."""
        self.moments.append(moment)
        if moment.is_new and moment.observation is not None and moment.belief is not None:
            self._rows.append(moment.observation)
            self._beliefs.append(moment.belief.probabilities)
        phase = moment.belief.phase if moment.belief else None
        self.actions.extend(Action(command, phase) for command in moment.commands)

    @property
    def stretches(self) -> list[tuple[Action, float, int]]:
        """The actions with follow-ups joined: the first one, when the last ended, how many.

        A drive or a look that is sent again because its goal moved, in answer to the same visit
        of a phase, is one stretch.
        """
        joined: list[tuple[Action, float, int]] = []
        newest: dict[str, int] = {}  # by channel, since the phase last changed
        for number, action in enumerate(self.actions):
            if number and action.phase is not self.actions[number - 1].phase:
                newest.clear()
            place = newest.get(action.channel)
            if place is not None and joined[place][0].label == action.label:
                first, end, count = joined[place]
                joined[place] = first, max(end, action.end), count + 1
            else:
                newest[action.channel] = len(joined)
                joined.append((action, action.end, 1))
        return joined

    @property
    def duration(self) -> float:
        """When the last moment was [s]."""
        return self.moments[-1].t if self.moments else 0.0

    @property
    def observations(self) -> Observations:
        """Every observation of the run."""
        return Observations.from_rows(self._rows, self.title)

    @property
    def probabilities(self) -> FloatArray:
        """The belief after each of them, (T, 6)."""
        return np.array(self._beliefs).reshape(-1, len(Phase))

    @property
    def phases(self) -> list[Phase]:
        """The phases the reading went through, each stretch once."""
        numbers = (self.probabilities.argmax(axis=1) + 1).tolist() if self._beliefs else []
        return [Phase(n) for i, n in enumerate(numbers) if i == 0 or n != numbers[i - 1]]

    @property
    def robot_path(self) -> FloatArray:
        """The robot in the world, (N, 3) x y [m] yaw [rad]."""
        return np.array([m.robot for m in self.moments]).reshape(-1, 3)

    @property
    def person_path(self) -> FloatArray:
        """The person in the world, (N, 2) [m]; NaN while out of sight."""
        out: Vec3 = (math.nan, math.nan, math.nan)
        places = [m.robot.to_world(m.person.head) if m.person else out for m in self.moments]
        return np.array(places).reshape(-1, 3)[:, :2]

    @property
    def moment_phases(self) -> IntArray:
        """The most probable phase at each moment, 1-6, 0 before the first belief, (N,)."""
        return np.array([m.belief.phase if m.belief else 0 for m in self.moments], dtype=np.int64)

    def require_readings(self) -> None:
        """Refuse an encounter in which nothing could be read.

        Raises:
            ParameterError: the source gave no observation.
        """
        if not self._rows:
            raise ParameterError(
                f"{self.title}: nothing to read; somebody must be seen, for at least one interval"
                f" of {Sampler().period:g} s"
            )
