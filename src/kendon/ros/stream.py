"""The person of a topic: messages in at their stamps, frames with a time that grows out."""

from __future__ import annotations

from typing import Any

from kendon.errors import DataError
from kendon.person import PersonFrame
from kendon.ros.settings import Input, NodeSettings
from kendon.sources.ros_faces import frame_of_face
from kendon.sources.ros_people import People
from kendon.sources.ros_place import RobotPlace
from kendon.sources.ros_stamps import StreamClock, seconds

#: Somebody who is not seen for so long makes way for another one [s].
_MAKES_WAY = 1.0
#: So many people are remembered by their names, and so many kinds of mistakes.
_KNOWN, _MISTAKES = 1000, 20
_NANO = 1e-9


class PersonStream:
    """Turns messages into frames of the person to greet.

    Of several faces that are told apart by their ids, the first one is followed until it is not
    seen any more.

    Args:
        place: where the robot is.
        settings: what the user said.
        topic: where the messages come from, for notes.
    """

    def __init__(self, place: RobotPlace, settings: NodeSettings, topic: str) -> None:
        self.clock = StreamClock(topic)
        self.refused = 0  # messages that could not be read
        self._place = place
        self._settings = settings
        self._people = People(settings.face_height, place.bases)
        self._numbers: dict[tuple[int, str], int] = {}  # clock's restart and id -> number
        self._count = 0  # of all people so far
        self._target: str | None = None  # the id of the face that is followed
        self._target_seen = 0.0  # [s], when, by the node's clock
        self._refusals: list[str] = []
        self._offset = 0.0  # [s], from times to stamps

    @property
    def notes(self) -> list[str]:
        """What a user should know so far, one sentence each."""
        return [*self.clock.notes, *self._refusals]

    def hear(self, topic: str, message: Any, came: int) -> list[PersonFrame]:
        """The frames that a message completes.

        Args:
            topic: of the message; where the robot is does not count here.
            message: with the fields of its type.
            came: when [ns].
        """
        if topic.startswith("/tf"):
            return []
        frame = self.take(message, came * _NANO)
        return [frame] if frame is not None else []

    def pass_time(self, now: int) -> list[PersonFrame]:
        """The frames that are complete when time has passed up to `now` [ns]."""
        del now  # a message is a frame, at once
        return []

    def at(self, now: float) -> float | None:
        """The time up to which no more frames are to be expected; None before the first [s]."""
        return self.clock.at(now)

    def take(self, message: Any, now: float) -> PersonFrame | None:
        """The frame that a message tells, or None if it must be left out.

        Args:
            message: a `FaceExtraction` or a ``PoseArray``, as the settings say.
            now: when it came, by the node's clock [s].
        """
        people = self._settings.input is Input.PEOPLE
        if not people and not self._follows(message.face_id, now):
            return None
        stamp = seconds(message.header.stamp) or now
        t = self.timed(seconds(message.header.stamp), now)
        if t is None:
            return None
        robot = self._place.at(stamp)
        try:
            if people:
                who = [self.number(str(i)) for i in range(len(message.poses))]
                return self._people.frame(message, t, robot, who)
            bases, number = self._place.bases, self.number(message.face_id)
            return frame_of_face(message, t, robot, bases=bases, who=number)
        except DataError as error:
            self.refuse(str(error))
            return None

    def timed(self, stamp: float, now: float) -> float | None:
        """The time of a message by its stamp (0 = none), or None if it must be left out [s]."""
        t = self.clock.take(stamp, now)
        if t is not None:
            self._offset = (stamp or now) - t
        return t

    def stamp(self, t: float) -> float:
        """The stamp that belongs to a time near that of the newest message [s]."""
        return max(0.0, t + self._offset)

    def number(self, name: str) -> int:
        """What somebody is known by; another number after the clock began again."""
        key = self.clock.restarts, name
        if key not in self._numbers:
            self._numbers[key] = self._count
            self._count += 1
            if len(self._numbers) > _KNOWN:
                del self._numbers[next(iter(self._numbers))]
        return self._numbers[key]

    def refuse(self, reason: str) -> None:
        """Count a message that cannot be read, and note why, once."""
        self.refused += 1
        self.note(f"A message of {self.clock.topic} is left out: {reason}.")

    def note(self, sentence: str) -> None:
        """Keep a sentence for the user."""
        if sentence not in self._refusals and len(self._refusals) < _MISTAKES:
            self._refusals.append(sentence)

    def _follows(self, name: str, now: float) -> bool:
        """Whether this face is the one to follow."""
        if self._settings.person:
            return name == self._settings.person
        if name != self._target and (
            self._target is None or now - self._target_seen > _MAKES_WAY or now < self._target_seen
        ):
            self._target = name
        if name == self._target:
            self._target_seen = now
        return name == self._target
