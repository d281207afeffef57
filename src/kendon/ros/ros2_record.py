"""What a node hears and says as an mcap bag, and such a bag read again as if it were heard."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from kendon.errors import DataError
from kendon.outputs import make_folder_for
from kendon.ros.ros2_reading import PeopleReader, Told
from kendon.ros.ros2_types import type_store
from kendon.sources.ros_bags import read_messages

#: What a recording ends in.
SUFFIX = ".mcap"


class Recorder:
    """Writes messages into an mcap file, which is there when the recorder is closed.

    Args:
        path: of the file.

    Raises:
        DataError: the file has another ending, exists already, or cannot be made.
        MissingExtraError: rosbags is not installed.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() != SUFFIX:
            raise DataError(f"a recording ends in {SUFFIX}", file=path)
        if path.exists():
            raise DataError("this recording exists already; name another one", file=path)
        make_folder_for(path)
        self._store = type_store()
        from rosbags.rosbag2 import StoragePlugin, Writer

        self._path = path
        # rosbags writes a folder; the file in it is a whole recording when it is finished.
        try:
            self._folder = Path(tempfile.mkdtemp(prefix=f".{path.stem}-", dir=path.parent))
        except OSError as error:
            raise DataError(f"cannot be recorded into ({error.strerror})", file=path) from None
        inner = self._folder / "bag"
        self._writer = Writer(inner, version=9, storage_plugin=StoragePlugin.MCAP)
        self._writer.open()
        self._connections: dict[tuple[str, str], Any] = {}
        self.count = 0  # messages

    def write(self, topic: str, kind: str, received: int, raw: bytes) -> None:
        """Record a message: its topic and type, when it came [ns], and its bytes (CDR)."""
        key = topic, kind
        if key not in self._connections:
            added = self._writer.add_connection(topic, kind, typestore=self._store)
            self._connections[key] = added
        self._writer.write(self._connections[key], received, raw)
        self.count += 1

    def close(self) -> None:
        """Finish the file; one without any message is not kept."""
        self._writer.close()
        if self.count:
            (found,) = self._folder.glob(f"**/*{SUFFIX}")
            found.replace(self._path)
        shutil.rmtree(self._folder)


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
