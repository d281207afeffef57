"""What a ROS 1 node hears and tells as a bag, and such a bag heard again."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from kendon.errors import DataError, MissingExtraError
from kendon.ros.hearing import LOCALISED, STATIC, TRANSFORMS, Hearing
from kendon.ros.humans import make_stream
from kendon.ros.parts import ReadingPart, Told
from kendon.ros.recording import Recording
from kendon.ros.settings import Input, NodeSettings, Part
from kendon.ros.watching import Watcher
from kendon.sources.ros4hri import HumansLog
from kendon.sources.ros_bags import read_messages, topic_types
from kendon.sources.ros_place import RobotPlace

#: The messages that tell of people, by the input that they are.
_INPUTS = {
    "kendon_msgs/msg/FaceExtraction": Input.FACES,
    "geometry_msgs/msg/PoseArray": Input.PEOPLE,
}
_LOCALISED = "geometry_msgs/msg/PoseWithCovarianceStamped"


class RawMessage(NamedTuple):
    """A message as it goes over the wire, and what it means."""

    kind: str  # as ROS 1 writes it: std_msgs/String
    md5: str
    text: str  # the definition, with those of all that it is made of
    data: bytes

    @classmethod
    def of(cls, message: Any) -> RawMessage:
        """That of a message of rospy."""
        buffer = io.BytesIO()
        message.serialize(buffer)
        return cls(message._type, message._md5sum, message._full_text, buffer.getvalue())

    @property
    def name(self) -> str:
        """The type as rosbags writes it: std_msgs/msg/String."""
        package, _, name = self.kind.partition("/")
        return f"{package}/msg/{name}"


class BagRecorder(Recording):
    """Writes messages into a ROS 1 bag; see `Recording`."""

    suffix, system = ".bag", "ROS 1"

    def write(self, topic: str, raw: RawMessage, came: int) -> None:
        """Record a message: its topic, and when it came [ns]."""

        def connect() -> Any:
            return self._writer.add_connection(topic, raw.name, msgdef=raw.text, md5sum=raw.md5)

        self._write((topic, raw.md5), connect, came, raw.data)

    def _make_writer(self, folder: Path) -> tuple[Any, Path, BinaryIO]:
        try:
            from rosbags.rosbag1 import Writer
        except ImportError as error:
            raise MissingExtraError("recording ROS bags", "bags", "rosbags") from error
        writer = Writer(folder / self._path.name)
        writer.open()
        assert writer.bio is not None
        return writer, writer.path, writer.bio


def replay(path: Path, settings: NodeSettings | None = None) -> Iterator[Told]:
    """What a node told of a recording, as if its messages were heard now; needs no ROS.

    Args:
        path: of a bag that `BagRecorder` has written.
        settings: those of the node; the input is found in the bag.

    Raises:
        MissingExtraError: rosbags is not installed.
        DataError: the bag is missing or torn, or nobody is told of in it.
    """
    kinds = topic_types(path)
    inputs = {_INPUTS[kind] for kind in kinds.values() if kind in _INPUTS}
    if not inputs and TRANSFORMS in kinds:
        inputs = {Input.HUMANS}
    if len(inputs) != 1:
        raise DataError(
            f"a node's recording tells of people in one way ({', '.join(c.value for c in Input)});"
            f" its topics: {', '.join(sorted(kinds)) or 'none'}",
            file=path,
        )
    (way,) = inputs
    chosen = (settings or NodeSettings()).with_values({"part": Part.READING, "input": way})
    place = RobotPlace(chosen.base_frame or None)
    stream = make_stream(place, chosen, path.name)
    part = ReadingPart(stream, Watcher(place, chosen.robot_face), chosen)
    hearing = Hearing(place, stream, part)
    for topic, received, message in read_messages(path, lambda _: True):
        kind = kinds[topic]
        if kind == _LOCALISED:
            yield from hearing.take(LOCALISED, message, received)
        elif (
            topic in (TRANSFORMS, STATIC)
            or kind in _INPUTS
            or (way is Input.HUMANS and HumansLog.wanted(topic))
        ):
            yield from hearing.take(topic, message, received)
        else:  # what was told then: time had passed
            yield from hearing.pass_time(received)
