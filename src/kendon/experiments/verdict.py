"""Whether a robot answered a person as chapter 4 of the thesis prescribes, and how soon.

What is judged is what the person could see of the robot, not what it meant:

| phase | the robot's answer (thesis 4.1.2)                                  |
|-------|--------------------------------------------------------------------|
| IA    | its face points at the person's (turned to them, figure 4.3)        |
| DS    | it waves (figure 4.5)                                               |
| HD    | its face points at half the person's height (figure 4.6)            |
| APP   | it drives up to them, or has, its face down (figure 4.7)            |
| FA    | it drives up to them, or has, its face at theirs (figure 4.9)       |
| CS    | it offers its hand (figure 4.10)                                    |
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from kendon.greeter import Encounter
from kendon.phases import Phase
from kendon.simulation.reacting import MIND
from kendon.sources.simulated import ReactingSource, Station

#: What is over so soon [s] cannot be read, and is not judged: a movement before the next
#: observation, and a phase that is only passed through before two of them.
SHORTEST_SHOWN, SHORTEST = 0.2, 0.4
#: So long after a phase has ended the robot may still answer it [s].
LATE = 1.5
#: Nearer than this the robot may not come before the handshake [m].
PERSONAL = 0.8
#: A robot that has come nearer to a passer-by by more than this has approached them [m].
APPROACHED = 0.5
#: A face that points within this of something looks at it [rad].
_LOOKS = math.radians(15)
#: Bases slower than this stand [m/s]; within that of the person the robot has arrived [m].
_STANDS, _ARRIVED = 0.05, 1.35
#: The gesture each phase is shown by, if by any.
_SHOWN = {Phase.DS: "dsal", Phase.HD: "hdip", Phase.CS: "csal"}
#: Movements of the head alone.
HEADS = ("nod", "toss", "dip")
#: Out of sight for longer than this is lost [s].
_LOST = 1.0


@dataclass(frozen=True)
class Visit:
    """One stretch of a phase and its answer."""

    phase: Phase
    begin: float  # [s]
    end: float  # [s]
    answer: float  # [s], when the answer was first to be seen; NaN = never
    shown: str = ""  # the movement it was shown by, if it was by one

    @property
    def answered(self) -> bool:
        """Whether it was."""
        return self.answer == self.answer

    @property
    def delay(self) -> float:
        """From the change of phase to the answer [s]; 0 if the robot did so already."""
        return self.answer - self.begin


@dataclass(frozen=True)
class Verdict:
    """What there is to say about one encounter."""

    number: int
    temperament: str
    greets: bool  # whether the person meant to greet at all
    visits: tuple[Visit, ...]
    gave_up: str  # why the person did, "" if they did not
    nearest: float  # [m], how close the two came
    intruded: bool  # the robot moved nearer than `PERSONAL` before the handshake
    lost: float  # [s], the longest the person was out of the robot's sight while greeting
    approach: float  # [m], how far the robot came toward a person by its own motion
    unprompted: int  # waves and hands that answered nothing
    step_backs: int
    duration: float  # [s]

    @property
    def failures(self) -> tuple[str, ...]:
        """What went wrong, in words."""
        found = [
            f"{v.phase.name}{f' ({v.shown})' if v.shown else ''} at {v.begin:.1f} s unanswered"
            for v in self.visits
            if not v.answered
        ]
        if self.greets and self.gave_up not in ("", MIND):
            found.append(f"the person gave up: {self.gave_up}")
        if self.intruded:
            found.append(f"the robot came within {PERSONAL:g} m before the handshake")
        if self.out_of_sight:
            found.append(f"the person was out of sight for {self.lost:.1f} s")
        if not self.greets and self.approach > APPROACHED:
            found.append(f"the robot went {self.approach:.1f} m toward a passer-by")
        return tuple(found)

    @property
    def complete(self) -> bool:
        """Whether every phase was answered and the person did not give up on the robot."""
        mind = self.gave_up in ("", MIND)
        return mind and all(v.answered for v in self.visits)

    @property
    def complete_but_for_heads(self) -> bool:
        """The same, where what only a head shows, and what follows from it, counts for nothing."""
        heads = any(v.shown in HEADS and not v.answered for v in self.visits)
        mind = heads or self.gave_up in ("", MIND)
        return mind and all(v.answered or v.shown in HEADS for v in self.visits)

    @property
    def in_order(self) -> bool:
        """Whether the answers came in the order of the phases."""
        times = [v.answer for v in self.visits if v.answered]
        return times == sorted(times)

    @property
    def out_of_sight(self) -> bool:
        """Whether the person was lost while greeting."""
        return self.greets and self.lost > _LOST


def judge(number: int, encounter: Encounter, source: ReactingSource) -> Verdict:
    """Judge an encounter by what was true at each tenth of a second."""
    truth, person = source.truth, source.person
    answers = {phase: _answers(truth, phase, person.actor.height) for phase in Phase}
    visits = tuple(
        Visit(
            phase, begin, end, _first(truth, answers[phase], begin, end + LATE),
            _shown(source, phase, begin, end),
        )
        for phase, begin, end in visits_of(truth)
        if end - begin >= (SHORTEST_SHOWN if phase in _SHOWN else SHORTEST) - 1e-6
    )  # fmt: skip
    away = np.array([math.dist(s.place, s.robot.pose[:2]) for s in truth])
    coming = _coming(truth)
    close = next((i for i, s in enumerate(truth) if s.phase is Phase.CS), len(truth))
    return Verdict(
        number=number,
        temperament=person.temperament.name,
        greets=person.temperament.greets,
        visits=visits,
        gave_up=person.gave_up,
        nearest=float(away.min()),
        intruded=bool(((away < PERSONAL) & (coming > _STANDS))[:close].any()),
        lost=_lost(encounter, truth),
        approach=float(coming.clip(0).sum() / 10),
        unprompted=_unprompted(truth),
        step_backs=person.step_backs,
        duration=truth[-1].t,
    )


def visits_of(truth: Sequence[Station]) -> list[tuple[Phase, float, float]]:
    """The person's phases in order, with when each began and ended [s]."""
    found: list[tuple[Phase, float, float]] = []
    for station in truth:
        if station.phase is None:
            continue
        if found and found[-1][0] is station.phase and station.t - found[-1][2] < 0.15:
            found[-1] = (station.phase, found[-1][1], station.t)
        else:
            found.append((station.phase, station.t, station.t))
    return found


def _answers(truth: Sequence[Station], phase: Phase, height: float) -> list[bool]:
    """At each instant, whether the robot shows the answer to a phase."""
    coming = _coming(truth)
    found = []
    for station, speed in zip(truth, coming.tolist(), strict=True):
        robot, (x, y) = station.robot, station.place
        face, half = robot.looks_at((x, y, height)), robot.looks_at((x, y, height / 2))
        looks, lowers = face < _LOOKS and face < half, half < _LOOKS and half < face
        drives = speed > _STANDS or math.dist((x, y), robot.pose[:2]) < _ARRIVED
        match phase:
            case Phase.IA:
                found.append(face < _LOOKS)
            case Phase.DS:
                found.append(robot.gesture == "wave")
            case Phase.HD:
                found.append(lowers)
            case Phase.APP:
                found.append(drives and lowers)
            case Phase.FA:
                found.append(drives and looks)
            case Phase.CS:
                found.append(robot.gesture == "handshake")
    return found


def _shown(source: ReactingSource, phase: Phase, begin: float, end: float) -> str:
    """The movement that a salutation or dip was made of."""
    gesture = _SHOWN.get(phase)
    for m in source.person.made:
        if m.gesture == gesture and m.begin < end and m.end > begin:
            return m.kind
    return ""


def _first(truth: Sequence[Station], shown: list[bool], begin: float, until: float) -> float:
    for station, there in zip(truth, shown, strict=True):
        if there and begin - 1e-6 <= station.t <= until:
            return station.t
    return math.nan


def _coming(truth: Sequence[Station]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """How fast the robot moves toward where the person is [m/s], by its own motion."""
    speeds = [0.0]
    for before, now in pairwise(truth):
        x, y = now.place
        was, here = (math.hypot(x - s.robot.pose.x, y - s.robot.pose.y) for s in (before, now))
        speeds.append((was - here) / (now.t - before.t))
    return np.array(speeds)


def _lost(encounter: Encounter, truth: Sequence[Station]) -> float:
    """The longest time for which a person who greets was not seen [s]."""
    last = max((s.t for s in truth if s.phase is not None), default=0.0)
    longest, since = 0.0, None
    for moment in encounter.moments:
        if moment.person is None and moment.t <= last:
            since = moment.t if since is None else since
            longest = max(longest, moment.t - since)
        else:
            since = None
    return longest


def _unprompted(truth: Sequence[Station]) -> int:
    """How many waves and hands the robot began to which no salutation had led."""
    salutations = {"wave": (Phase.DS, Phase.CS), "handshake": (Phase.CS,)}
    visits = visits_of(truth)
    count, last = 0, None
    for station in truth:
        gesture = station.robot.gesture
        if gesture != last and gesture in salutations:
            led = (
                phase in salutations[gesture] and begin - 0.5 <= station.t <= end + LATE
                for phase, begin, end in visits
            )
            count += not any(led)
        last = gesture
    return count
