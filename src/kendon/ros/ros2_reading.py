"""Everybody's phases from the messages of ROS 2, as they come; no transport, and no clock.

What is read depends only on the messages and when they came: played again from a recording, they
give the same beliefs. Time passes in steps of 0.1 s, so that somebody who is no longer told of is
known to be gone.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

from kendon.errors import DataError
from kendon.features import ROBOT_FACE, Sampler
from kendon.features.sampler import TOLERANCE
from kendon.geometry import Vec3
from kendon.greeter import FORGOTTEN
from kendon.models import Belief, GreetingModel, Tracker
from kendon.observations import Observation
from kendon.phases import Phase
from kendon.sources.bag_people import BagOptions
from kendon.sources.live_people import NUMBERS, PATIENCE, HeardFrame, LivePeople
from kendon.sources.ros4hri import HumansLog, Person
from kendon.sources.ros_faces import frame_of_face
from kendon.sources.ros_place import RobotPlace
from kendon.sources.ros_stamps import StreamClock, seconds

#: kendon's own input: faces in the robot's base frame (thesis 3.3).
FACES = "/faces"
#: Where the robot is, by its own account.
ODOMETRY = "/odom"
#: Time passes in such steps [ns]: a tick of the behaviour tree (thesis 4.1.1).
TICK = 100_000_000
#: Intervals end so much later than frames wait where no frame tells that they have [ns].
_MARGIN = 50_000_000
#: Inside this gaze feature somebody looks at the robot (thesis 3.3.3: the rim of the cone).
_LOOKING = 1.0
#: So many kinds of mistakes in messages are spoken of.
_MISTAKES = 20
_NANO = 10**9
_NO_NAME = re.compile(r"[^A-Za-z0-9_]")


class Engagement(IntEnum):
    """The levels of ``hri_msgs/EngagementLevel``."""

    UNKNOWN = 0
    DISENGAGED = 1
    ENGAGING = 2
    ENGAGED = 3
    DISENGAGING = 4


def engagement(before: Engagement, belief: Belief, observation: Observation) -> Engagement:
    """How engaged somebody is, from the phase of their greeting and their gaze.

    Who greets from near is engaged, who is on the way there is engaging. Who only begins to
    approach does so by looking at the robot; after the greeting, looking away is disengaging.

    Args:
        before: the level until now.
        belief: the newest.
        observation: what it was read from.
    """
    if belief.phase is Phase.CS:
        return Engagement.ENGAGED
    looks = observation.gaze < _LOOKING  # false where it is unknown
    if before in (Engagement.ENGAGED, Engagement.DISENGAGING) and not looks:
        return Engagement.DISENGAGING
    if belief.phase is Phase.IA and not looks:
        return Engagement.DISENGAGED
    return Engagement.ENGAGING


class Told(NamedTuple):
    """What is known of somebody after an interval."""

    name: str  # fit for a topic
    stamp: int  # [ns], the interval's end, by the clock of the messages
    observation: Observation | None  # None = gone, or not seen yet
    belief: Belief | None
    engagement: Engagement


@dataclass(eq=False)
class _Reading:
    name: str
    ids: set[str]
    sampler: Sampler
    tracker: Tracker
    zero: int  # [ns], when the frames' time is 0
    number: int
    newest: float = -math.inf  # [s], the time of the newest frame
    seen: float = math.nan  # [s], when last
    level: Engagement = Engagement.UNKNOWN


class PeopleReader:
    """Reads the phases of everybody who is told of.

    Args:
        model: reads the phases.
        options: what is known of the robot's frames.
        face: the robot's face in its base frame [m].
        place: told where the robot is.
        on_frame: given every frame of the person who is followed, and which of all it is.
        patience: how late messages may be [s].
    """

    def __init__(
        self,
        model: GreetingModel,
        options: BagOptions | None = None,
        face: Vec3 = ROBOT_FACE,
        place: RobotPlace | None = None,
        on_frame: Callable[[HeardFrame, int], None] | None = None,
        patience: float = PATIENCE,
    ) -> None:
        self.people = LivePeople(options, patience)
        self.place = place or RobotPlace((options or BagOptions()).base)
        self.frames = 0  # that were heard
        self.model = model
        self.zero = 0  # [ns], when the newest frame's time is 0
        self._face = face
        self._on_frame = on_frame
        self._faces: dict[str, StreamClock] = {}  # by the faces' ids
        self._faces_zero: float | None = None  # [s]
        self._notes: list[str] = []
        self._left_out: set[tuple[str, str]] = set()  # topics, and why messages of them were
        self._late = 0  # frames of intervals that had been told
        self._readings: list[_Reading] = []  # in the order in which they came
        self._count = 0  # of all people so far
        self._next: int | None = None  # [ns], when the next step of time is
        self._newest = (0, 0)  # [ns], the newest frame's stamp, and when it was given

    @staticmethod
    def wanted(topic: str) -> bool:
        """Whether `hear` makes use of a topic's messages."""
        return topic in (FACES, ODOMETRY) or HumansLog.wanted(topic)

    @property
    def notes(self) -> list[str]:
        """What a user should know, one sentence each."""
        told = [note for clock in self._faces.values() for note in clock.notes]
        return list(dict.fromkeys([*self.people.notes, *self._notes, *told]))

    @property
    def late(self) -> int:
        """Frames that were left out, as they came too late."""
        return self._late + self.people.late + sum(clock.late for clock in self._faces.values())

    @property
    def followed(self) -> str | None:
        """Whoever has been there longest."""
        return self._readings[0].name if self._readings else None

    def clock(self, now: int) -> int:
        """What the clock of the frames shows at a time of receipt, both in ns; 0 if none came."""
        stamp, given = self._newest
        return stamp + now - given if stamp else 0

    @property
    def hold(self) -> int:
        """So long frames may be under way [ns]."""
        return self.people.patience + _MARGIN + self.people.order

    def hear(self, topic: str, message: Any, received: int) -> list[Told]:
        """Take in a message, as a ROS library gives it.

        Args:
            topic: its name, with the slash before it.
            message: with the fields of its type.
            received: when it came [ns]; never before the last one.
        """
        told = self.pass_time(received)
        try:
            if topic == FACES:
                return told + self._hear_face(message, received)
            if topic == ODOMETRY:
                self.place.take_localised(message)
                return told
            if topic in ("/tf", "/tf_static"):
                self.place.take_transforms(message, static=topic == "/tf_static")
            if self.people.take(topic, message, received):
                told += self._all_gone()
        except (AttributeError, TypeError, ValueError) as error:
            self._leave_out(topic, f"it is none as it should be ({error})")
        return told + self._take_frames(received)

    def pass_time(self, now: int) -> list[Told]:
        """Let time pass, in steps, up to `now` [ns]."""
        if self._next is None:
            self._next = (now // TICK + 1) * TICK
        told: list[Told] = []
        while self._next <= now:
            told += self._take_frames(self._next, max(1, self.clock(self._next) - self.hold))
            told += self._step(self._next)
            self._next += TICK
        return told

    def _take_frames(self, now: int, ending: int = 0) -> list[Told]:
        """Take in the frames that are complete of those whose intervals they, or the time, end.

        Args:
            now: the time of receipt [ns].
            ending: intervals that end by this stamp do so in any case; 0 = none does [ns].
        """

        def due(person: Person) -> int:
            known = self._known(person)
            if known is None or (self._on_frame and known is self._readings[0]):
                return -1  # the robot looks at whom it follows frame by frame
            end = known.sampler.next_end
            if not math.isfinite(end) or known.zero + round(end * _NANO) <= ending + 1:
                return -1
            return known.zero + round((end + TOLERANCE) * _NANO)

        return [
            told
            for heard in self.people.give(now, due, everybody=bool(ending))
            for told in self._take(heard, self.people.start, self._given(heard, now, ending))
        ]

    def _given(self, heard: HeardFrame, now: int, ending: int) -> int:
        """When a frame counts as given, which the clock of the frames goes by [ns].

        One that was held back until time ended its interval does not set that clock back.
        """
        stamp, given = self._newest
        return min(now, given + heard.stamp - stamp) if ending and stamp else now

    def _hear_face(self, message: Any, received: int) -> list[Told]:
        name = message.face_id or "face"
        clock = self._faces.setdefault(name, StreamClock(FACES))
        t = clock.take(seconds(message.header.stamp), received / _NANO)
        if t is None:
            return []
        if clock.restarts:  # all begins anew, at the new stamps
            gone = self._all_gone()
            self._drop_clocks(list(self._faces))
            self._faces_zero = None
            return gone + self._hear_face(message, received)
        self._faces_zero = t if self._faces_zero is None else self._faces_zero
        zero, bases = self._faces_zero, self.place.bases
        try:
            frame = frame_of_face(message, t - zero, self.place.at(t), bases=bases)
        except DataError as error:
            self._leave_out(FACES, str(error))
            return []
        start = round(zero * _NANO)
        heard = HeardFrame(Person(name, (name,), ()), start + round(frame.t * _NANO), frame)
        return self._take(heard, start, received)

    def _leave_out(self, topic: str, reason: str) -> None:
        """Say why a message does not count; once, whatever numbers are in the reason."""
        kind = topic, NUMBERS.sub("", reason)
        if kind not in self._left_out and len(self._left_out) < _MISTAKES:
            self._left_out.add(kind)
            self._notes.append(f"A message of {topic} is left out: {reason}.")

    def _drop_clocks(self, names: Iterable[str]) -> None:
        """Forget the clocks of faces, but not what was said of them."""
        for clock in map(self._faces.pop, names):
            self._late += clock.late
            self._notes += [note for note in clock.notes if note not in self._notes]

    def _take(self, heard: HeardFrame, zero: int, now: int) -> list[Told]:
        self.frames += 1
        if heard.stamp > self._newest[0]:
            self._newest = heard.stamp, now
        self.zero = zero
        reading = self._reading(heard.person, zero)
        sampler = reading.sampler
        # Two ids that turn out to be one person's may both have told of one time.
        if heard.frame.t <= max(reading.newest, sampler.next_end - sampler.period + TOLERANCE):
            self._late += 1
            return []
        reading.newest = heard.frame.t
        if heard.frame.seen:
            reading.seen = heard.frame.t
        if self._on_frame and reading is self._readings[0]:
            self._on_frame(heard, reading.number)
        return [self._observe(reading, o) for o in sampler.push(heard.frame)]

    def _reading(self, person: Person, zero: int) -> _Reading:
        known = self._known(person)
        if known is not None:
            known.ids = person.ids
            return known
        self._count += 1
        anonymous = person.name in (*person.faces, *person.bodies)
        name = _NO_NAME.sub("_", person.name)
        name = f"anonymous_person_{name}" if anonymous else name
        made = _Reading(
            name, person.ids, Sampler(self._face), self.model.tracker(), zero, self._count
        )
        self._readings.append(made)
        return made

    def _known(self, person: Person) -> _Reading | None:
        ids = person.ids
        return next((one for one in self._readings if not ids.isdisjoint(one.ids)), None)

    def _step(self, now: int) -> list[Told]:
        told: list[Told] = []
        for reading in list(self._readings):
            t = (self.clock(now) - reading.zero - self.hold) / _NANO
            told += [self._observe(reading, o) for o in reading.sampler.advance(t)]
            # Never placed counts as never seen: such a reading lasts while frames come.
            if t - reading.seen > FORGOTTEN or (math.isnan(reading.seen) and self._silent(now)):
                self._readings.remove(reading)
                self._drop_clocks(reading.ids & self._faces.keys())
                told.append(self._gone(reading))
        return told

    def _silent(self, now: int) -> bool:
        return now - self._newest[1] > FORGOTTEN * _NANO

    def _all_gone(self) -> list[Told]:
        told = [self._gone(reading) for reading in self._readings]
        self._readings.clear()
        self._newest = 0, 0
        return told

    def _gone(self, reading: _Reading) -> Told:
        return Told(reading.name, self._newest[0], None, None, Engagement.UNKNOWN)

    def _observe(self, reading: _Reading, observation: Observation) -> Told:
        stamp = reading.zero + round(observation.t * _NANO)
        if math.isnan(reading.seen):  # a belief about nobody would follow the odds alone
            return Told(reading.name, stamp, observation, None, Engagement.UNKNOWN)
        belief = reading.tracker.step(observation)
        reading.level = engagement(reading.level, belief, observation)
        return Told(reading.name, stamp, observation, belief, reading.level)
