"""What a node hears and says as an mcap bag, and such a bag read again as if it were heard."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from kendon.ros.recording import Recording
from kendon.ros.ros2_reading import PeopleReader, Told
from kendon.ros.ros2_types import type_store
from kendon.sources.ros_bags import read_messages


class Recorder(Recording):
    """Writes messages of ROS 2 into an mcap file; see `Recording`."""

    suffix, system = ".mcap", "ROS 2"

    def write(self, topic: str, kind: str, received: int, raw: bytes) -> None:
        """Record a message: its topic and type, when it came [ns], and its bytes (CDR)."""

        def connect() -> Any:
            return self._writer.add_connection(topic, kind, typestore=type_store())

        self._write((topic, kind), connect, received, raw)

    def _make_writer(self, folder: Path) -> tuple[Any, Path, BinaryIO]:
        type_store()  # it says how to install rosbags
        from rosbags.rosbag2 import StoragePlugin, Writer

        writer = Writer(folder / "bag", version=9, storage_plugin=StoragePlugin.MCAP)
        writer.open()
        storage: Any = writer.storage
        return writer, storage.path, storage.bio


def replay(path: Path, reader: PeopleReader) -> Iterator[Told]:
    """What a reader tells of a recording, as if its messages were heard now.

    Raises:
        DataError: the recording is missing or torn, or holds what cannot be right.
        MissingExtraError: rosbags is not installed.
    """
    for topic, received, message in read_messages(path, lambda _: True):
        if reader.wanted(topic):
            yield from reader.hear(topic, message, received)
        else:  # what was told then: time had passed
            yield from reader.pass_time(received)
