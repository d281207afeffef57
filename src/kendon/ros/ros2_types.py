"""Messages of ROS 2 without ROS: their definitions, made from plain fields, to bytes and back.

rosbags is the codec. The standard messages are those of Humble, which have not changed since;
``hri_msgs`` (REP-155) and ``kendon_msgs`` are added to them.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from kendon.errors import MissingExtraError, ParameterError
from kendon.ros.messages import definitions
from kendon.ros.ros2_transport import Fields
from kendon.sources.ros_bags import HRI_DEFINITIONS

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

TRANSFORMS = "tf2_msgs/msg/TFMessage"
STRING = "std_msgs/msg/String"
FACE = "kendon_msgs/msg/FaceExtraction"
OBSERVATION = "kendon_msgs/msg/Observation"
BELIEF = "kendon_msgs/msg/Belief"
ENGAGEMENT = "hri_msgs/msg/EngagementLevel"


@functools.cache
def type_store() -> Typestore:
    """The definitions of all messages that are known.

    Raises:
        MissingExtraError: rosbags is not installed.
    """
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError as error:
        raise MissingExtraError("messages of ROS 2", "ros2", "rosbags") from error
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in HRI_DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    for file, text in definitions("kendon_msgs").items():
        name = f"kendon_msgs/msg/{file.removesuffix('.msg')}"
        store.register(get_types_from_msg(text, name))
    return store


def build(kind: str, fields: Fields) -> Any:
    """A message of rosbags from some of its fields; the others are 0, empty or their default.

    Args:
        kind: the message's type, such as ``std_msgs/msg/String``.
        fields: by name.

    Raises:
        ParameterError: the type has no such field.
    """
    store = type_store()
    described = dict(store.fielddefs[kind][1])
    unknown = fields.keys() - described.keys()
    if unknown:
        valid = ", ".join(described)
        raise ParameterError(f"{kind} has no field {min(unknown)!r}; valid: {valid}")
    values = {name: _value(fields.get(name), field) for name, field in described.items()}
    return store.types[kind](**values)


@functools.cache
def prepare_codec(kind: str) -> None:
    """Let rosbags make its code for a message type now: at the first message it takes 0.1 s."""
    store = type_store()
    store.deserialize_cdr(store.serialize_cdr(build(kind, {}), kind), kind)


def _value(given: Any, field: Any) -> Any:
    """The value of a field as rosbags describes it: (kind of node, what it is of)."""
    from rosbags.interfaces import Nodetype

    node, inner = field
    if node == Nodetype.NAME:
        return build(inner, given or {})
    if node == Nodetype.BASE:
        if given is not None:
            return given
        if inner[0] in ("string", "wstring"):
            return ""
        return False if inner[0] == "bool" else 0
    part, length = inner
    length = length if node == Nodetype.ARRAY else 0
    if part[0] == Nodetype.BASE and part[1][0] not in ("string", "wstring"):
        kind = "uint8" if part[1][0] in ("byte", "octet", "char") else part[1][0]
        return np.zeros(length, dtype=kind) if given is None else np.asarray(given, dtype=kind)
    return [_value(one, part) for one in (given if given is not None else [None] * length)]


def stamp_fields(stamp: int) -> Fields:
    """A time in whole nanoseconds as the fields of ``builtin_interfaces/msg/Time``."""
    seconds, rest = divmod(stamp, 10**9)
    return {"sec": seconds, "nanosec": rest}


def header_fields(stamp: int, frame: str) -> Fields:
    """The fields of a ``std_msgs/msg/Header``."""
    return {"stamp": stamp_fields(stamp), "frame_id": frame}
