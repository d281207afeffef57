"""What a node makes of the messages of one greeting; no transport, and no clock of its own.

What is told depends only on the messages and when they came: heard again from a recording, they
give the same. Time passes in steps, so that an interval ends though nothing comes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from kendon.errors import UnknownNameError
from kendon.person import PersonFrame
from kendon.ros.parts import AnsweringPart, NodePart, Told
from kendon.ros.stream import PersonStream
from kendon.ros.telling import phase_of_state
from kendon.sources.ros_place import RobotPlace

#: What tells where the robot is, and what phase another node has read.
TRANSFORMS, STATIC, LOCALISED, STATE = "/tf", "/tf_static", "amcl_pose", "state"
#: Time passes in such steps [ns].
STEP = 20_000_000
#: A clock that leaps ahead by more than this is followed from here on [ns].
_LEAP = 10_000_000_000
#: One that goes back by more has begun again [ns].
_BACK = 1_000_000_000
_NANO = 1e-9


class Hearing:
    """Gives the messages to who makes use of them, and lets time pass between them.

    Args:
        place: told where the robot is.
        stream: told of people.
        part: what the node does with them.
    """

    def __init__(self, place: RobotPlace, stream: PersonStream, part: NodePart) -> None:
        self.place, self.stream, self.part = place, stream, part
        self.newest = 0  # [ns], up to when time has passed
        self._next: int | None = None  # [ns], when the next step is

    def arrival(self, now: int) -> int:
        """When a message counts as having come: never before what has been told already [ns]."""
        return now if self.newest - now > _BACK else max(self.newest + 1, now)

    def take(self, role: str, message: Any, came: int) -> Iterator[Told]:
        """Take in a message; what there is to tell up to it.

        Args:
            role: `TRANSFORMS`, `STATIC`, `LOCALISED` or `STATE`; else the topic, by which people
                are told of.
            message: with the fields of its type.
            came: what `arrival` gave [ns].
        """
        yield from self.pass_time(came)
        if role == STATE:
            self._state(message, came)
            return
        if role in (TRANSFORMS, STATIC):
            self.place.take_transforms(message, static=role == STATIC)
        elif role == LOCALISED:
            self.place.take_localised(message)
            return
        yield from self._frames(self.stream.hear(role, message, came), came)

    def pass_time(self, now: int) -> Iterator[Told]:
        """What there is to tell as time passes up to `now` [ns]."""
        if self._next is None or self._next - now > _BACK:
            self._next = (now // STEP + 1) * STEP
        self._next = max(self._next, (now - _LEAP) // STEP * STEP)
        while self._next <= now:
            at = self.newest = self._next
            self._next += STEP
            yield from self._frames(self.stream.pass_time(at), at)
            yield from self.part.idle(at * _NANO)
        self.newest = now

    def _frames(self, frames: Iterable[PersonFrame], now: int) -> Iterator[Told]:
        for frame in frames:
            yield from self.part.frame(frame, now * _NANO)

    def _state(self, message: Any, came: int) -> None:
        if not isinstance(self.part, AnsweringPart):
            return
        try:
            self.part.state(phase_of_state(message), came * _NANO)
        except UnknownNameError as error:
            self.stream.note(f"A message that tells the state is left out: {error}.")
