"""People of ROS4HRI (REP-155) heard live: a frame of each as soon as all about it has come.

What a stream gives depends only on its messages and when they came, never on a clock of its own:
played again from a recording, it gives the same. Messages count at their stamps. A frame waits
until the transforms and Action Units that are regularly told have come for its stamp, but no
longer than its patience; where faces come out of order, it waits as long as the latest one did.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, NamedTuple

from kendon.errors import DataError, KendonError
from kendon.person import IntArray, PersonFrame
from kendon.sources.bag_people import (
    BASES,
    BagOptions,
    PeopleReading,
    PlacingState,
    listed,
)
from kendon.sources.heads import FACE_LOST, heads, newest_head
from kendon.sources.ros4hri import TWO_CLOCKS, HumansLog, Person
from kendon.sources.ros_stamps import StampGuard, nanoseconds

#: A frame waits so long for what is missing about it, by when its messages came [s].
PATIENCE = 0.25
#: So long the first frames wait for the robot's own frames, which are told by others [ns].
SETTLING = 1_000_000_000
#: So long messages are remembered, by their stamps [ns]; longer where one is more patient.
MEMORY = 3_000_000_000
#: Somebody who is tracked for so long without a place is spoken of [ns].
_UNPLACED = 3_000_000_000
#: From so many lags one can tell whether there are two clocks.
_LAGS = 20
#: What differs where the same is said again.
NUMBERS = re.compile(r"-?\b(inf|\d+(\.\d+)?(e[-+]?\d+)?)\b")
_NANO = 1e-9


class HeardFrame(NamedTuple):
    """A frame of somebody."""

    person: Person
    stamp: int  # [ns]
    frame: PersonFrame  # its time is in seconds since the first frame of anybody


class LivePeople:
    """Takes in messages as they come, and gives the frames that are complete.

    Args:
        options: what is known of the robot's frames.
        patience: how long a frame waits for what is missing about it [s].
    """

    def __init__(self, options: BagOptions | None = None, patience: float = PATIENCE) -> None:
        self.log = HumansLog()
        self.notes: list[str] = []  # what a user should know, one sentence each
        self.order = 0  # [ns], so long frames wait as others came out of order
        self.late = 0  # frames that came after a newer one had been given, and are left out
        self.patience = round(patience * 10**9)  # [ns]
        self._options = options or BagOptions()
        self._frames: set[str] = set()  # those that the reading knows
        self._people: list[Person] = []
        self._by_id: dict[str, Person] = {}
        self._new_notes: list[str] = []  # of the reading
        self._said: set[str] = set()  # the notes without their numbers
        self._judged = False  # whether it is known if there are two clocks
        self._restart()

    def _restart(self) -> None:
        self._state: PlacingState | None = None
        self._reading: PeopleReading | None = None
        self._first: int | None = None  # [ns], when the first person was heard of
        self._given: dict[str, int] = {}  # id -> stamp of the newest frame given [ns]
        self._waiting: dict[tuple[str, int], int] = {}  # frame, stamp -> since when [ns]
        self._newest = 0  # [ns], the newest stamp of a head
        self._forgotten = 0  # [ns], what is older is
        self._placed = False
        self._changed = True
        self._told: set[str] = set()  # the names of those who may have a frame to give
        self._guard = StampGuard()

    @property
    def start(self) -> int:
        """When the frames' time is 0 [ns]; 0 before the first."""
        return self._state.start if self._state else 0

    def take(self, topic: str, message: Any, received: int) -> bool:
        """Take in a message, as a ROS library gives it.

        Args:
            topic: its name, with the slash before it.
            message: with the fields of its type.
            received: when it came [ns].

        Returns:
            Whether the clock has been set back: all begins anew.
        """
        if topic == "/tf":
            message = self._without_strays(message, received)
        try:
            self._changed |= self.log.take(topic, message, received)
        except DataError as error:
            self._note(f"{str(error).split(':')[0]}: the clock was set back, all begins anew.")
            self.log.restart()
            self._restart()
            return True
        if topic == "/tf":
            self._count_late(message)
        return False

    def give(
        self, now: int, due: Callable[[Person], int] = lambda _: -1, *, everybody: bool = True
    ) -> list[HeardFrame]:
        """The frames that are complete, each person's in order.

        Args:
            now: by the clock that messages are received by [ns].
            due: the stamp after which there must be one of somebody's before any are wanted [ns]:
                to place several at once takes no longer than to place one.
            everybody: otherwise only who was told of since they were last looked at.
        """
        people = self._who()
        if not people:
            return []
        self._first = now if self._first is None else self._first
        if now - self._first < SETTLING:
            return []
        if not everybody:
            people = [person for person in people if person.name in self._told]
            if not people:
                return []
        try:
            reading = self._read(self._people)
        except DataError as error:  # the base asked for may yet be told of
            self._note(f"{error}.", "base")
            self._forget()
            return []
        found: list[HeardFrame] = []
        for person in people:
            given = max(self._given.get(i, -1) for i in person.ids)
            wanted = max(given, due(person))
            if newest_head(self.log.transforms, person) <= wanted:
                self._told.discard(person.name)
                continue
            stamps, frames = heads(self.log.transforms, person, given)
            count = self._complete(reading, person, stamps.tolist(), frames, now)
            if not count or stamps[count - 1] <= wanted:
                continue
            for key in zip(frames[:count], stamps[:count].tolist(), strict=True):
                self._waiting.pop(key, None)
            self._given[person.name] = int(stamps[count - 1])
            placed = self._place(reading, person, stamps[:count], frames[:count])
            found += placed
            if any(heard.frame.seen for heard in placed):
                self._placed = True
            elif placed and not self._placed and now - self._first > _UNPLACED:
                self._note(f"{reading.why_unknown(frames[0], stamps)}.")
        self._tell_new()
        self._forget()
        return found

    def _place(
        self, reading: PeopleReading, person: Person, stamps: IntArray, frames: list[str]
    ) -> list[HeardFrame]:
        """The frames of somebody at some stamps, but for those that cannot be."""
        try:
            track = reading.track(person, stamps, frames, self._new_notes)
        except KendonError as error:
            if len(stamps) > 1:  # not all of them are wrong for one that is
                return [
                    heard
                    for i in range(len(stamps))
                    for heard in self._place(reading, person, stamps[i : i + 1], [frames[i]])
                ]
            self._note(f"Left out: {error}.")
            return []
        return [
            HeardFrame(person, stamp, frame)
            for stamp, frame in zip(stamps.tolist(), track, strict=True)
        ]

    def unplaced(self) -> str:
        """Why nobody has been placed although somebody is tracked; "" if it is not so."""
        names = [] if self._people else self.log.unplaced()
        if not names:
            return ""
        return f"{listed(names)} tracked, but no transform places a frame face_ID or head_ID"

    def _who(self) -> list[Person]:
        frames = set(self.log.transforms.frames) if self._changed or not self._people else None
        if frames is not None:
            self._changed = False
            self._people = self.log.people()
            self._by_id = {i: person for person in self._people for i in person.ids}
            self._told.update(person.name for person in self._people)
            if frames != self._frames:
                self._frames, self._reading = frames, None
        return self._people

    def _read(self, people: list[Person]) -> PeopleReading:
        if self._reading is None:
            based = self._state is not None and self._state.mounted is None
            self._reading = PeopleReading(None, self.log, people, self._options, self._state)
            if self._state is not None and self._reading.has_base and not based:
                self._note(f"the robot's base ({' or '.join(BASES)}) is told only now.")
                self._reading.state.mounted = None
            self._state = self._reading.state
        return self._reading

    def _complete(
        self,
        reading: PeopleReading,
        person: Person,
        stamps: list[int],
        frames: list[str],
        now: int,
    ) -> int:
        """How many of the frames to come are complete, or have waited long enough."""
        if not stamps:
            return 0
        tree = self.log.transforms
        self._newest = max(self._newest, stamps[-1])
        order = max(tree.lateness(frame) for frame in dict.fromkeys(frames))
        self.order = max(self.order, order)
        count = 0
        for stamp, frame in zip(stamps, frames, strict=True):
            since = self._waiting.setdefault((frame, stamp), now)
            settle = order
            if frame.startswith("head_") and person.faces:
                settle = max(order, FACE_LOST)  # the face may yet be there
            early = stamps[-1] - stamp < settle
            missing = early or reading.awaited(person, stamp, frame, self.patience)
            if missing and now - since < self.patience + order:
                break
            count += 1
        return count

    def _without_strays(self, message: Any, received: int) -> Any:
        """A message without the transforms that are stamped with quite another time."""
        kept = []
        for told in message.transforms:
            child, stamp = told.child_frame_id.lstrip("/"), nanoseconds(told.header.stamp)
            if stamp == 0 or self._guard.fits(child, stamp, received):
                kept.append(told)
            else:
                self._note(f"A transform of {child} is stamped {stamp * _NANO:.3f} s: left out.")
        if len(kept) == len(message.transforms):
            return message
        return SimpleNamespace(transforms=kept)

    def _count_late(self, message: Any) -> None:
        for told in message.transforms:
            child = told.child_frame_id.lstrip("/")
            if child not in self._frames:
                self._changed = True
            elif child.startswith(("face_", "head_")):
                person = self._by_id.get(child.split("_", 1)[1])
                if person is not None:
                    self._told.add(person.name)
                    stamp = nanoseconds(told.header.stamp)
                    given = max(self._given.get(i, -1) for i in person.ids)
                    self.late += 0 < stamp < given

    def _forget(self) -> None:
        before = self._newest - max(MEMORY, 2 * self.patience)
        if before - self._forgotten > MEMORY // 10:
            self._forgotten = before
            self.log.forget(before)
            self._guard.forget(set(self.log.transforms.frames))
            self._changed = True
            self._waiting = {k: since for k, since in self._waiting.items() if k[1] >= before}

    def _note(self, sentence: str, kind: str = "") -> None:
        sentence = sentence[0].upper() + sentence[1:]
        # Piece by piece, the same is said of other times.
        kind = kind or NUMBERS.sub("", sentence)
        if kind not in self._said:
            self._said.add(kind)
            self.notes.append(sentence)

    def _tell_new(self) -> None:
        for sentence in self._new_notes:
            self._note(sentence)
        self._new_notes.clear()
        if self._judged or self.log.lags < _LAGS:
            return
        self._judged = True
        lag = self.log.lag
        if abs(lag) > TWO_CLOCKS:
            way = "behind" if lag > 0 else "ahead of"
            self._note(
                f"The messages' stamps are {abs(lag):.1f} s {way} this computer's clock: these are"
                " two clocks (another computer's, or a simulator's); the stamps are used."
            )
