"""Writes small ROS bags with ROS4HRI people, to read them back: ROS 1, ROS 2 db3 and mcap."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

#: What bags can be, and what they end in.
KINDS = ("db3", "mcap", "bag")

#: Texts of messages that rosbags does not bring, as their packages write them.
_HRI = {
    "hri_msgs/msg/IdsList": "std_msgs/Header header\nstring[] ids\n",
    "hri_msgs/msg/IdsMatch": (
        "int8 UNSET=0\nint8 PERSON=1\nint8 FACE=2\nint8 BODY=3\nint8 VOICE=4\nstring id1\n"
        "int8 id1_type\nstring id2\nint8 id2_type\nfloat32 confidence\n"
    ),
    "hri_msgs/msg/FacialActionUnits": (
        "std_msgs/Header header\nfloat32[99] intensity\nfloat32[99] confidence\n"
    ),
}
_TF = {"tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n"}
_NANO = 10**9
#: Where the clock of these bags begins [s].
EPOCH = 1_700_000_000


class Transform(NamedTuple):
    """One transform: when it holds [s], the pose of the child in the parent."""

    t: float
    parent: str
    child: str
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    static: bool = False
    lag: float = 0.0005  # from stamp to receipt [s]


class Text(NamedTuple):
    """A std_msgs/String: when it was received [s], on which topic, what."""

    t: float
    topic: str
    data: str


class Ids(NamedTuple):
    """A hri_msgs/IdsList."""

    t: float
    topic: str
    ids: list[str]


class Match(NamedTuple):
    """A hri_msgs/IdsMatch; kinds are 1 person, 2 face, 3 body."""

    t: float
    one: tuple[int, str]
    two: tuple[int, str]
    confidence: float


class Units(NamedTuple):
    """A hri_msgs/FacialActionUnits: stamp [s], face id, intensity and confidence by code."""

    t: float
    face: str
    intensity: Mapping[int, float]
    confidence: Mapping[int, float] = {}


Told = Transform | Text | Ids | Match | Units


def write_bag(folder: Path, kind: str, told: Iterable[Told], name: str = "people") -> Path:
    """Write what is told into a bag of a kind of `KINDS`; returns what is to be opened."""
    ros1 = kind == "bag"
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    for msgtype, text in (_HRI | (_TF if ros1 else {})).items():
        store.register(get_types_from_msg(text, msgtype))
    make = _Messages(store.types, ros1)
    path = folder / (f"{name}.bag" if ros1 else name)
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    writer: Any = Writer1(path) if ros1 else Writer2(path, version=9, storage_plugin=plugin)
    connections: dict[str, Any] = {}
    messages = sorted((make(one) for one in told), key=lambda message: message[0])
    with writer:
        for received, topic, msgtype, message in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msgtype, typestore=store)
            if ros1:
                raw = store.serialize_ros1(message, msgtype)
            else:
                raw = store.serialize_cdr(message, msgtype)
            writer.write(connections[topic], received, raw)
    return path


class _Messages:
    """Makes messages of a type store: (received [ns], topic, type, message)."""

    def __init__(self, types: Mapping[str, Any], ros1: bool) -> None:
        self._types = types
        self._seq = {"seq": 0} if ros1 else {}

    def __call__(self, told: Told) -> tuple[int, str, str, Any]:
        if isinstance(told, Transform):
            return self._transform(told)
        received = _ns(told.t)
        if isinstance(told, Text):
            msgtype = "std_msgs/msg/String"
            return received, told.topic, msgtype, self._types[msgtype](data=told.data)
        if isinstance(told, Ids):
            msgtype = "hri_msgs/msg/IdsList"
            message = self._types[msgtype](header=self._header(told.t, ""), ids=told.ids)
            return received, told.topic, msgtype, message
        if isinstance(told, Match):
            msgtype = "hri_msgs/msg/IdsMatch"
            (kind1, id1), (kind2, id2) = told.one, told.two
            message = self._types[msgtype](
                id1=id1, id1_type=kind1, id2=id2, id2_type=kind2, confidence=told.confidence
            )
            return received, "/humans/candidate_matches", msgtype, message
        msgtype = "hri_msgs/msg/FacialActionUnits"
        message = self._types[msgtype](
            header=self._header(told.t, ""),
            intensity=_by_code(told.intensity),
            confidence=_by_code(told.confidence),
        )
        return received, f"/humans/faces/{told.face}/facs", msgtype, message

    def _transform(self, told: Transform) -> tuple[int, str, str, Any]:
        kinds = self._types
        message = kinds["tf2_msgs/msg/TFMessage"](
            transforms=[
                kinds["geometry_msgs/msg/TransformStamped"](
                    header=self._header(told.t, told.parent),
                    child_frame_id=told.child,
                    transform=kinds["geometry_msgs/msg/Transform"](
                        translation=kinds["geometry_msgs/msg/Vector3"](*told.position),
                        rotation=kinds["geometry_msgs/msg/Quaternion"](*told.rotation),
                    ),
                )
            ]
        )
        topic = "/tf_static" if told.static else "/tf"
        return _ns(told.t + told.lag), topic, "tf2_msgs/msg/TFMessage", message

    def _header(self, t: float, frame: str) -> Any:
        stamp = self._types["builtin_interfaces/msg/Time"](*divmod(_ns(t), _NANO))
        return self._types["std_msgs/msg/Header"](**self._seq, stamp=stamp, frame_id=frame)


def _ns(t: float) -> int:
    return EPOCH * _NANO + round(t * _NANO)


def _by_code(values: Mapping[int, float]) -> Any:
    result = np.zeros(99, dtype=np.float32)
    for code, value in values.items():
        result[code] = value
    return result
