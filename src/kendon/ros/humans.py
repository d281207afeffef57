"""The person of ROS4HRI's topics (REP-155): placed by TF, of all who are there the one to greet."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from kendon.errors import DataError
from kendon.person import PersonFrame
from kendon.ros.settings import Input, NodeSettings
from kendon.ros.stream import PersonStream
from kendon.sources.bag_people import BagOptions
from kendon.sources.base import CameraMount
from kendon.sources.live_people import HeardFrame, LivePeople
from kendon.sources.ros_place import RobotPlace

#: Frames are looked for so often though nothing comes [ns].
_LOOKED = 100_000_000
#: They come so late at most, where something about them is missing [s].
_UNDER_WAY = 0.25
_NANO = 1e-9


class HumansStream(PersonStream):
    """Turns ROS4HRI's messages into frames of the person to greet.

    Of several people the first one is followed until they are not seen any more. Without a base
    in /tf, the camera is taken to be the robot's face.

    Args:
        place: where the robot is.
        settings: what the user said.
        topic: that of the transforms, for notes.
    """

    def __init__(self, place: RobotPlace, settings: NodeSettings, topic: str) -> None:
        super().__init__(place, settings, topic)
        camera = CameraMount(settings.robot_face)
        self._live = LivePeople(BagOptions(settings.base_frame or None, camera))
        self._ids: set[str] = set()  # all that the person who is followed goes by

    @property
    def notes(self) -> list[str]:
        """What a user should know so far, one sentence each."""
        return [*self._live.notes, *super().notes]

    def hear(self, topic: str, message: Any, came: int) -> list[PersonFrame]:
        """The frames that a message completes; see `PersonStream`."""
        try:
            self._live.take(topic, message, came)
        except (AttributeError, TypeError, ValueError):
            self.note(f"The messages of {topic} are not those of REP-155; they are left out.")
            return []
        return list(self._given(came))

    def pass_time(self, now: int) -> list[PersonFrame]:
        """The frames that are complete when time has passed up to `now` [ns]."""
        return [] if now % _LOOKED else list(self._given(now))

    def at(self, now: float) -> float | None:
        """The time up to which no more frames are to be expected; None before the first [s]."""
        t = super().at(now)
        return None if t is None else t - _UNDER_WAY - self._live.order * _NANO

    def _given(self, now: int) -> Iterator[PersonFrame]:
        try:
            found = self._live.give(now)
        except DataError as error:
            self.note(f"{error}.")
            return
        for heard in found:
            if not self._is_followed(heard, now * _NANO):
                continue
            stamp = heard.stamp * _NANO
            t = self.timed(stamp, now * _NANO)
            if t is not None:
                who = self.number(self._target or heard.person.name)
                yield heard.frame._replace(t=t, who=who, robot=self._place.at(stamp))

    def _is_followed(self, heard: HeardFrame, now: float) -> bool:
        person = heard.person
        if self._settings.person:
            return self._settings.person in person.ids
        if self._ids & person.ids:  # a face that was anonymous is known as a person's, later
            self._ids = set(person.ids)
            if heard.frame.seen:
                self._target_seen = now
            return True
        if heard.frame.seen and self._follows(person.name, now):
            self._ids = set(person.ids)
            return True
        return False


def make_stream(place: RobotPlace, settings: NodeSettings, topic: str) -> PersonStream:
    """The stream of people that the settings ask for.

    Args:
        place: where the robot is.
        settings: what the user said.
        topic: where the messages come from, for notes.
    """
    if settings.input is Input.HUMANS:
        return HumansStream(place, settings, topic)
    return PersonStream(place, settings, topic)
