"""Somebody of ROS4HRI (REP-155) who greets without an end: human_topics.py [SECONDS]

Their face is told of 30 times a second. After each so many seconds a line of JSON tells in how
many observations their smile was known: both /tf and /humans/... must have been heard for it.
"""

from __future__ import annotations

import json
import math
import sys
import time
from typing import Any

import numpy as np

from kendon.person import PersonFrame
from kendon.ros.ros1.connection import start_node
from kendon.ros.ros1.environment import messages, ros_module
from kendon.simulation import SimulatedPerson, script

RATE = 30


class HumanTopics:
    """Publishes a face and its Action Units.

    Args:
        transforms: the topic of its frames.
    """

    def __init__(self, transforms: str = "/tf") -> None:
        rospy, tf2 = ros_module("rospy"), ros_module("tf2_msgs.msg")
        kind, self._units_of = facial_units()
        self._made = tf2.TFMessage
        self.frames = rospy.Publisher(transforms, tf2.TFMessage, queue_size=100)
        self.units = rospy.Publisher("/humans/faces/ab/facs", kind, queue_size=100)

    def tell(self, frame: PersonFrame, stamp: Any) -> None:
        self.units.publish(self._units_of(stamp.to_nsec(), frame.smile))
        gaze = (-0.5, 0.5, -0.5, 0.5)
        self.frames.publish(self._made([
            transform("base_footprint", "face_ab", stamp, frame.head, frame.head_rotation),
            transform("face_ab", "gaze_ab", stamp, (0, 0, 0), gaze),
        ]))  # fmt: skip

    def connected(self) -> bool:
        return all(end.get_num_connections() for end in (self.frames, self.units))

    def close(self) -> None:
        for end in (self.frames, self.units):
            end.unregister()


def transform(parent: str, child: str, stamp: Any, place: Any, turn: Any) -> Any:
    geometry = ros_module("geometry_msgs.msg")
    told = geometry.TransformStamped()
    told.header.stamp, told.header.frame_id, told.child_frame_id = stamp, parent, child
    told.transform.translation = geometry.Vector3(*place)
    told.transform.rotation = geometry.Quaternion(*turn)
    return told


def facial_units() -> tuple[Any, Any]:
    """A class of hri_msgs/FacialActionUnits for rospy, and what makes one of a stamp and a smile.

    It has a field more than the one that kendon knows, as another version of hri_msgs might.
    """
    from rosbags import typesys

    name = "hri_msgs/msg/FacialActionUnits"
    text = "std_msgs/Header header\nfloat32[99] intensity\nfloat32[99] confidence\nuint8 more\n"
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    store.register(typesys.get_types_from_msg(text, name))
    definition, md5 = store.generate_msgdef(name, ros_version=1)
    types = store.types

    class Units(ros_module("genpy").Message):  # type: ignore[misc]
        _type, _md5sum, _full_text = "hri_msgs/FacialActionUnits", md5, definition
        _has_header = False  # rospy would count messages in it
        __slots__ = ("data",)
        _slot_types = ("string",)

        def serialize(self, buffer: Any) -> None:
            buffer.write(self.data)

    def make(stamp: int, smile: float) -> Any:
        time = types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
        intensity = np.zeros(99, dtype=np.float32)
        intensity[[1, 6, 12]] = 5.0, smile, smile  # the first tells of the scale
        header = types["std_msgs/msg/Header"](0, time, "")
        sure = np.ones(99, dtype=np.float32)
        return Units(bytes(store.serialize_ros1(types[name](header, intensity, sure, 0), name)))

    return Units, make


def main(seconds: float) -> None:
    start_node("humans_peer")
    rospy = ros_module("rospy")
    topics, smiles = HumanTopics(), [0]

    def take(observation: Any) -> None:
        smiles[0] += not math.isnan(observation.smile)

    rospy.Subscriber("/observation", messages("kendon_msgs").Observation, take)
    next_told = time.monotonic() + seconds
    while True:
        person = SimulatedPerson(script("short"), rate=RATE)
        while not person.finished:
            topics.tell(person.frame(), rospy.Time.now())
            person.step()
            time.sleep(1 / RATE)
            if time.monotonic() >= next_told:
                next_told += seconds
                print(json.dumps({"smiles": smiles[0]}), flush=True)
                smiles[0] = 0


if __name__ == "__main__":
    main(float(sys.argv[1]) if sys.argv[1:] else 1.0)
