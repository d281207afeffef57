"""Messages out of ROS bags without ROS: ROS 1 ``.bag`` files, ROS 2 folders, .db3 and .mcap files.

The bag's own message definitions are used. Bags of ROS 2 Humble and older hold none in .db3
files; then those of Humble stand in, and the current ones of ``hri_msgs`` (REP-155).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from kendon.errors import DataError, MissingExtraError

#: What a bag that is a single file ends in.
BAG_SUFFIXES = (".bag", ".mcap", ".db3")
#: What may mend a recording that was broken off.
_MENDS = {".bag": "rosbag reindex", ".mcap": "mcap recover"}
_MENDS_ROS2 = "ros2 bag reindex"
#: The file that makes a folder a ROS 2 bag.
METADATA = "metadata.yaml"

#: The messages of ``hri_msgs`` that are read or written, where nothing else defines them.
HRI_DEFINITIONS = {
    "hri_msgs/msg/IdsList": "std_msgs/Header header\nstring[] ids\n",
    "hri_msgs/msg/IdsMatch": (
        "int8 UNSET=0\nint8 PERSON=1\nint8 FACE=2\nint8 BODY=3\nint8 VOICE=4\n"
        "string id1\nint8 id1_type\nstring id2\nint8 id2_type\nfloat32 confidence\n"
    ),
    "hri_msgs/msg/FacialActionUnits": (
        "std_msgs/Header header\nfloat32[99] intensity\nfloat32[99] confidence\n"
    ),
    "hri_msgs/msg/EngagementLevel": (
        "std_msgs/Header header\nuint8 UNKNOWN=0\nuint8 DISENGAGED=1\nuint8 ENGAGING=2\n"
        "uint8 ENGAGED=3\nuint8 DISENGAGING=4\nuint8 level\n"
    ),
}


class BagMessage(NamedTuple):
    """One message of a bag."""

    topic: str
    received: int  # [ns], by the recorder's clock
    message: Any


def is_bag(path: Path) -> bool:
    """Whether a path is that of a bag, by its name, or by what the folder holds."""
    if path.is_dir():
        return (path / METADATA).is_file()
    return path.suffix.lower() in BAG_SUFFIXES


def topic_types(path: Path) -> dict[str, str]:
    """The topics of a bag, and the type of each one's messages (``std_msgs/msg/String``).

    Raises:
        MissingExtraError: rosbags is not installed.
        DataError: there is no such bag, or it is torn.
    """
    with _opened(path) as reader:
        return {connection.topic: connection.msgtype for connection in reader.connections}


def read_messages(path: Path, wanted: Callable[[str], bool]) -> Iterator[BagMessage]:
    """The messages of a bag in the order in which they were received.

    Args:
        path: of a ``.bag``, ``.mcap`` or ``.db3`` file, or of a ROS 2 bag's folder.
        wanted: whether the messages of a topic are wanted.

    Raises:
        MissingExtraError: rosbags is not installed.
        DataError: there is no such bag, or it is torn.
    """
    with _opened(path) as reader:
        chosen = [c for c in reader.connections if wanted(c.topic)]
        if not chosen:  # rosbags would read everything
            return
        messages = reader.messages(connections=chosen)
        while True:
            try:
                connection, received, raw = next(messages)
                message = reader.deserialize(raw, connection.msgtype)
            except StopIteration:
                return
            except Exception as error:
                raise _torn(path, error) from None
            yield BagMessage(connection.topic, received, message)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Open a bag with rosbags."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError as error:
        raise MissingExtraError("reading ROS bags", "bags", "rosbags") from error
    if not path.exists():
        raise DataError("there is no such bag", file=path)
    if not is_bag(path):
        known = ", ".join(BAG_SUFFIXES)
        raise DataError(
            f"this is no ROS bag; bags are folders with a {METADATA}, or end in {known}", file=path
        )
    fallback = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in HRI_DEFINITIONS.items():
        fallback.register(get_types_from_msg(text, name))
    # A torn file can make its parsers raise anything at all.
    try:
        reader = AnyReader([path], default_typestore=fallback)
        reader.open()
    except Exception as error:
        raise _torn(path, error) from None
    try:
        have = reader.typestore.fielddefs
        missing = {name: d for name, d in fallback.fielddefs.items() if name not in have}
        reader.typestore.register(missing)
        yield reader
    finally:
        reader.close()


def _torn(path: Path, error: Exception) -> DataError:
    """What is told when rosbags cannot go on."""
    reason = " ".join(str(error).split()).rstrip(".") or type(error).__name__
    # rosbags names files with their whole path, and the message begins with it anyway.
    reason = reason.replace(str(path.parent) + "/", "")[:150]
    mend = _MENDS.get(path.suffix.lower(), _MENDS_ROS2)
    return DataError(
        f"this bag is torn, or none that rosbags can read ({reason}); `{mend}` may mend it",
        file=path,
    )
