"""People as kendon's own node was told of them: faces or poses in a bag (thesis 3.3, 3.6.4).

They are known by the types of their messages, whatever the topics were called. What counts, and
when, is as in the node: by stamps, where the robot was by what had been told until then.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from kendon.errors import DataError
from kendon.geometry import Pose2D
from kendon.person import PersonFrame, Track
from kendon.simulation.body import FACE_HEIGHT
from kendon.sources.bag_people import BagPerson
from kendon.sources.ros_bags import read_messages, topic_types
from kendon.sources.ros_faces import frame_of_face
from kendon.sources.ros_people import People
from kendon.sources.ros_place import RobotPlace
from kendon.sources.ros_stamps import StreamClock, seconds

FACES = "kendon_msgs/msg/FaceExtraction"
POSES = "geometry_msgs/msg/PoseArray"
_LOCALISED = ("geometry_msgs/msg/PoseWithCovarianceStamped", "nav_msgs/msg/Odometry")
_TRANSFORMS = {"/tf": False, "/tf_static": True}
#: What somebody is called whom nobody named.
NAMELESS = "person"
_NANO = 1e-9


def tells_of_faces(path: Path) -> bool:
    """Whether a bag holds messages of faces or poses.

    Raises:
        MissingExtraError: rosbags is not installed.
        DataError: there is no such bag, or it is torn.
    """
    return not {FACES, POSES}.isdisjoint(topic_types(path).values())


def people_told(path: Path) -> dict[str, BagPerson]:
    """Everybody of whom there are such messages, by name, in the order in which they came.

    Raises:
        MissingExtraError: rosbags is not installed.
        DataError: the bag is missing or torn, or tells of nobody.
    """
    heard = _Heard(topic_types(path))
    for topic, received, message in read_messages(path, heard.wanted):
        heard.take(topic, message, received)
    found = {
        name: BagPerson(
            Track.from_frames(frames, name=f"{path.stem}_{name}"),
            (*heard.clocks[name].notes, *heard.notes),
        )
        for name, frames in heard.frames.items()
        if any(frame.seen for frame in frames)
    }
    if not found:
        reason = "; ".join(heard.notes) or "its faces have no place"
        raise DataError(f"no people in this bag: {reason.rstrip('.')}", file=path)
    return found


class _Heard:
    """Takes in messages as they came."""

    def __init__(self, kinds: dict[str, str]) -> None:
        self.clocks: dict[str, StreamClock] = {}  # by the names of people
        self.frames: dict[str, list[PersonFrame]] = {}
        self.notes: list[str] = []
        self._kinds = kinds
        self._place = RobotPlace()
        self._people = People(FACE_HEIGHT, self._place.bases)
        self._zero: float | None = None  # [s]

    def wanted(self, topic: str) -> bool:
        """Whether `take` makes use of a topic's messages."""
        return topic in _TRANSFORMS or self._kinds[topic] in (FACES, POSES, *_LOCALISED)

    def take(self, topic: str, message: Any, received: int) -> None:
        """Take in a message that came at a time [ns]."""
        kind = self._kinds[topic]
        if topic in _TRANSFORMS:
            self._place.take_transforms(message, static=_TRANSFORMS[topic])
        elif kind in _LOCALISED:
            self._place.take_localised(message)
        elif kind == FACES:
            self._take_person(topic, message.face_id or NAMELESS, message, received)
        else:
            self._take_person(topic, NAMELESS, message, received)

    def _take_person(self, topic: str, name: str, message: Any, received: int) -> None:
        clock = self.clocks.setdefault(name, StreamClock(topic))
        stamp, now = seconds(message.header.stamp), received * _NANO
        t = clock.take(stamp, now)
        if t is None:
            return
        self._zero = t if self._zero is None else self._zero
        try:
            frame = self._frame(topic, message, t - self._zero, self._place.at(stamp or now))
        except DataError as error:
            sentence = f"A message of {topic} is left out: {error}."
            if sentence not in self.notes:
                self.notes.append(sentence)
            return
        self.frames.setdefault(name, []).append(frame)

    def _frame(self, topic: str, message: Any, t: float, robot: Pose2D) -> PersonFrame:
        if self._kinds[topic] == FACES:
            return frame_of_face(message, t, robot, bases=self._place.bases)
        return self._people.frame(message, t, robot, range(len(message.poses)))
