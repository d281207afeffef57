"""The types of ROS 2 messages for Cyclone DDS, whose samples stay the bytes that they are."""

from __future__ import annotations

import functools
from typing import Any

from kendon.errors import DataError
from kendon.ros.ros2_types import type_store

#: Names of ROS's primitive types that IDL spells otherwise.
_SPELT = {"byte": "uint8", "char": "uint8", "octet": "uint8"}


def dds_name(kind: str) -> str:
    """A ROS type's name on the wire.

    >>> dds_name("std_msgs/msg/String")
    'std_msgs::msg::dds_::String_'
    """
    package, _, name = kind.split("/")
    return f"{package}::msg::dds_::{name}_"


def ros_name(dds: str) -> str:
    """The ROS type of a name on the wire; the name itself where it is no message's.

    >>> ros_name("std_msgs::msg::dds_::String_")
    'std_msgs/msg/String'
    """
    parts = dds.split("::")
    if len(parts) == 4 and parts[1:3] == ["msg", "dds_"]:
        return f"{parts[0]}/msg/{parts[3].removesuffix('_')}"
    return dds


@functools.cache
def sample_type(kind: str) -> Any:
    """Cyclone's type of a ROS message; its samples hold the message in `raw`, as CDR.

    Raises:
        DataError: the message's definition is not known.
    """
    made = idl_struct(kind)

    def serialize(sample: Any, **_: Any) -> bytes:
        return bytes(sample.raw)

    def deserialize(cls: Any, data: bytes, /, **_: Any) -> Any:
        return wrapped(cls, data)

    made.serialize = serialize
    made.deserialize = classmethod(deserialize)
    return made


def wrapped(made: Any, raw: bytes) -> Any:
    """A sample of a type of `sample_type` from a message's bytes."""
    sample = made.__new__(made)
    sample.raw = raw
    return sample


def idl_struct(kind: str) -> Any:
    """The IDL struct of a ROS message, with a codec of Cyclone's own.

    Raises:
        DataError: the message's definition is not known.
    """
    from cyclonedds.idl import annotations, make_idl_struct

    known = type_store().fielddefs
    if kind not in known:
        raise DataError(f"the messages {kind} are not known here")
    fields = {name: _idl(field) for name, field in known[kind][1]}
    made = make_idl_struct(f"{kind.rsplit('/', 1)[1]}_", dds_name(kind).replace("::", "."), fields)
    return annotations.final(made)


_nested = functools.cache(idl_struct)


def _idl(field: Any) -> Any:
    """The IDL type of a field as rosbags describes it: (kind of node, what it is of)."""
    from cyclonedds.idl import types as idl_types
    from rosbags.interfaces import Nodetype

    types: Any = idl_types

    node, inner = field
    if node == Nodetype.NAME:
        return _nested(inner)
    if node == Nodetype.BASE:
        word, bound = inner
        if word == "string":
            return types.bounded_str[bound] if bound else str
        return bool if word == "bool" else getattr(types, _SPELT.get(word, word))
    part, length = inner
    if node == Nodetype.ARRAY:
        return types.array[_idl(part), length]
    return types.sequence[_idl(part), length] if length else types.sequence[_idl(part)]
