"""An encounter as a page needs it: stepped tick by tick, with a past that can be looked back at.

Nothing here knows a browser. What is kept is bounded, so that a page may stay open for days.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from kendon.features import Sampler
from kendon.geometry import Pose2D
from kendon.greeter import Action, Greeter, Moment
from kendon.observations import Observation
from kendon.person import PersonFrame
from kendon.phases import Phase
from kendon.robots import CommandKind, Robot
from kendon.sources import Source
from kendon.trees import TICK_RATE, GreetingTree
from kendon.viewer.browser.forms import Float32Array
from kendon.viewer.browser.person_form import Follower
from kendon.viewer.browser.robot_form import robot_form

#: How much of the past is kept [s], and how many commands.
HISTORY = 300.0
COMMANDS = 400
#: The robot's own log is cut back to this many commands, the newest.
_LOG = 200
#: Frames of the person kept a tick; a faster source is thinned out.
_FRAMES = 4

#: A look that misses the person's face by more goes elsewhere [m].
_ASIDE = 0.4

#: The states of a tree's node, by their place in `Snapshot.nodes`.
NODE_STATES = ("idle", "running", "success", "failure")


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Everything a page shows of one tick."""

    t: float  # [s], the flow's clock
    person: tuple[Float32Array, ...]  # since the tick before, oldest first; () = out of sight
    robot: Float32Array  # see `RobotForm`
    pose: Pose2D  # of the robot's base, in the world
    phase: Phase | None
    probabilities: tuple[float, ...]  # of the phases, () before the first belief
    observation: Observation | None
    is_new: bool  # whether the observation came with this tick
    nodes: bytes  # the state of each of the tree's nodes, places in NODE_STATES
    doing: str  # the robot, in a few words
    saying: str  # the robot, "" when silent

    @property
    def said(self) -> tuple[Phase | None, str, str]:
        """What the page says of it in words."""
        return self.phase, self.doing, self.saying

    @property
    def ground(self) -> tuple[float, float] | None:
        """Where the person's face is over the ground [m]; None out of sight."""
        if not self.person:
            return None
        x, y = self.person[-1][:2].tolist()
        return x, y


@dataclass(frozen=True, slots=True)
class Shown:
    """An instant as it is drawn, at a tick or on the way to it from the tick before."""

    snapshot: Snapshot
    person: Float32Array | None  # see `Follower`; None out of sight
    robot: Float32Array  # see `RobotForm`


@dataclass(frozen=True, slots=True)
class Node:
    """One node of the behaviour tree, for display."""

    name: str
    kind: str
    depth: int  # 0 is the root
    parent: int  # its place among the nodes; -1 for the root


class _Tap(Source):
    """A source that keeps what passes through it."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.name, self.reacts, self.live = source.name, source.reacts, source.live  # type: ignore[misc]
        self.passed: deque[PersonFrame] = deque(maxlen=64)

    @property
    def notes(self) -> tuple[str, ...]:  # type: ignore[override]
        return self.source.notes

    def attach(self, robot: Robot) -> None:
        self.source.attach(robot)

    def frames(self) -> Iterator[PersonFrame]:
        for frame in self.source.frames():
            self.passed.append(frame)
            yield frame


class Stage:
    """One encounter, from its start to wherever it has got.

    Args:
        greeter: the flow, which the stage runs; nobody else may.
        title: in a few words.
        history: how much of the past is kept [s].
    """

    def __init__(self, greeter: Greeter, title: str = "", history: float = HISTORY) -> None:
        self.title = title
        self.robot = greeter.robot
        self.form = robot_form(greeter.robot)
        self._tap = _Tap(greeter.source)
        greeter.source = self._tap
        self._greeter = greeter
        self._moments = greeter.run()
        self._follower = Follower()
        self.nodes = tree_nodes(greeter.tree)
        self.snapshots: deque[Snapshot] = deque(maxlen=round(history * TICK_RATE))
        self.actions: deque[Action] = deque(maxlen=COMMANDS)
        self.over = False

    @property
    def live(self) -> bool:
        """Whether the person is seen as it happens, so that time cannot be hurried."""
        return self._tap.source.live

    @property
    def now(self) -> float:
        """The newest tick [s]."""
        return self.snapshots[-1].t if self.snapshots else 0.0

    def advance(self) -> Snapshot | None:
        """Go on by one tick; None when the encounter is over.

        Raises:
            DataError: there is something wrong with what the source reads.
        """
        moment = next(self._moments, None)
        if moment is None:
            self.over = True
            return None
        return self._take(moment)

    def run(self) -> Iterator[Moment]:
        """Run the encounter to its end, moment by moment, for whoever wants those.

        Raises:
            DataError: there is something wrong with what the source reads.
        """
        for moment in self._moments:
            self._take(moment)
            yield moment
        self.over = True

    def _take(self, moment: Moment) -> Snapshot:
        phase = moment.belief.phase if moment.belief else None
        self.actions.extend(Action(command, phase) for command in moment.commands)
        snapshot = self._snapshot(moment, phase)
        self.snapshots.append(snapshot)
        self._greeter.shorten_log(_LOG)
        return snapshot

    def close(self) -> None:
        """End the encounter: the robot is told to stop."""
        self._moments.close()  # type: ignore[attr-defined]
        self.over = True

    def place_of(self, t: float) -> int:
        """Which of the snapshots shows a time, the newest that is not after it."""
        first = self.snapshots[0].t if self.snapshots else 0.0
        place = int((t - first) * TICK_RATE + 1e-6)
        return min(max(place, 0), len(self.snapshots) - 1)

    def shown(self, place: int, share: float = 1.0) -> Shown:
        """The instant of a snapshot, or a share of the way to it from the one before."""
        snapshot = self.snapshots[place]
        people, robot = snapshot.person, snapshot.robot
        person = people[min(int(share * len(people)), len(people) - 1)] if people else None
        if share < 1.0 and place > 0:
            robot = self.form.between(self.snapshots[place - 1].robot, robot, share)
        return Shown(snapshot, person, robot)

    def _snapshot(self, moment: Moment, phase: Phase | None) -> Snapshot:
        frames = list(self._tap.passed)
        self._tap.passed.clear()
        rows = [row for frame in frames if (row := self._follower.take(frame)) is not None]
        if not rows and moment.person is not None and self.snapshots:
            rows = list(self.snapshots[-1].person[-1:])  # a slow source: still where they were
        step = -(-len(rows) // _FRAMES) or 1
        belief = moment.belief
        return Snapshot(
            moment.t,
            tuple(rows[::-1][::step][::-1]) if moment.person is not None else (),
            self.form.state(self.robot),
            moment.robot,
            phase,
            tuple(belief.probabilities.tolist()) if belief else (),
            moment.observation,
            moment.is_new,
            bytes(NODE_STATES.index(s.status) for s in self._greeter.tree.states()),
            self._doing(),
            self._saying(),
        )

    def _doing(self) -> str:
        """What base and arms are at."""
        words = []
        if self.robot.running(CommandKind.GO_TO):
            words.append("drives")
        elif self.robot.running(CommandKind.TURN_TO):
            words.append("turns")
        gesture = self.robot.running(CommandKind.GESTURE)
        if gesture is not None and gesture.asked["name"] != "home":
            words.append(_GESTURE_WORDS.get(gesture.asked["name"], gesture.asked["name"]))
        return " and ".join(words) or self._looking()

    def _looking(self) -> str:
        """Where the robot has last been told to look."""
        looks = (c for c in reversed(self.robot.log) if c.kind is CommandKind.LOOK_AT)
        look, person = next(looks, None), self.robot.person
        if person is None:
            return "waits for somebody"
        if look is None or math.dist(look.asked["point"], person) > _ASIDE:
            return "looks elsewhere"
        return "looks at the person"

    def _saying(self) -> str:
        speech = self.robot.running(CommandKind.SAY)
        return str(speech.asked["text"]) if speech else ""


_GESTURE_WORDS = {"wave": "waves", "handshake": "offers its hand", "stretch": "stretches"}

#: Seconds between observations, for whoever draws them.
PERIOD = Sampler().period


def tree_nodes(tree: GreetingTree) -> tuple[Node, ...]:
    """The nodes of a tree in the order of their states."""
    nodes: list[Node] = []
    places: dict[str, int] = {}
    for place, state in enumerate(tree.states()):
        above = _above(state.path, places)
        depth = nodes[above].depth + 1 if above >= 0 else 0
        places[state.path] = place
        nodes.append(Node(state.name, state.kind, depth, above))
    return tuple(nodes)


def _above(path: str, places: dict[str, int]) -> int:
    """The place of the node above a path; names may themselves hold a slash."""
    while "/" in path:
        path = path.rpartition("/")[0]
        if path in places:
            return places[path]
    return -1
