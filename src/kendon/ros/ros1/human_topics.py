"""ROS4HRI's topics on ROS 1 (REP-155): found as people come and go, read without hri_msgs.

Messages carry the text of their definition, so that every version of ``hri_msgs`` is understood
and none needs to be installed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from kendon.ros.hearing import STATIC, TRANSFORMS
from kendon.ros.ros1.connection import master_errors
from kendon.ros.ros1.environment import ros_module
from kendon.sources.ros4hri import HumansLog

#: So many messages of one topic may wait.
_WAITING = 100


class Heard(NamedTuple):
    """A message as it came."""

    role: str  # see `kendon.ros.hearing.Hearing.take`
    topic: str  # resolved
    message: Any
    raw: Any  # as it can be recorded
    came: int  # [ns], by the node's clock


class HumanTopics:
    """Listens to what there is of ``/humans/...``.

    Args:
        put: takes each message, in a thread of ROS; fills in when it came.
    """

    def __init__(self, put: Callable[[Heard], None]) -> None:
        self._rospy = rospy = ros_module("rospy")
        self._master = ros_module("rosgraph").Master(rospy.get_name())
        self._put = put
        self._topics: dict[str, Any] = {}  # by name
        self._kinds: dict[str, Any] = {}  # classes by md5 sum

    def follow(self) -> None:
        """Listen to topics that are new, and no more to those that have gone."""
        try:
            offered = {topic for topic, _ in self._master.getPublishedTopics("/humans")}
        except master_errors():
            return  # what is connected goes on
        wanted = {topic for topic in offered if HumansLog.wanted(topic)} - {TRANSFORMS, STATIC}
        for topic in wanted - self._topics.keys():
            self._topics[topic] = self._rospy.Subscriber(
                topic, self._rospy.AnyMsg, self._came, topic, queue_size=_WAITING
            )
        for topic in self._topics.keys() - wanted:
            self._topics.pop(topic).unregister()

    def _came(self, raw: Any, topic: str) -> None:
        header = raw._connection_header
        md5 = header["md5sum"]
        if md5 not in self._kinds:
            made = ros_module("genpy.dynamic").generate_dynamic(
                header["type"], header["message_definition"]
            )
            self._kinds[md5] = made[header["type"]]
        message = self._kinds[md5]()
        message.deserialize(raw._buff)
        self._put(Heard(topic, topic, message, message, 0))
