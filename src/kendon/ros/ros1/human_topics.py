"""ROS4HRI's topics on ROS 1 (REP-155): found as people come and go, read without hri_msgs.

Publishers send the text of their message's definition ahead, so that every version of ``hri_msgs``
is understood and none needs to be installed. rosbags is the codec: classes that Debian's genpy
makes miscount fields of 99 numbers, which those of Action Units are.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from kendon.errors import MissingExtraError
from kendon.ros.hearing import STATIC, TRANSFORMS
from kendon.ros.ros1.connection import master_errors
from kendon.ros.ros1.environment import ros_module
from kendon.ros.ros1.record import RawMessage
from kendon.sources.ros4hri import HumansLog

#: So many messages of one topic may wait, and so much is read in one go [bytes].
_WAITING, _READ = 100, 2**20


class Heard(NamedTuple):
    """A message as it came."""

    role: str  # see `kendon.ros.hearing.Hearing.take`
    topic: str  # resolved
    message: Any
    came: int = 0  # [ns], by the node's clock
    raw: RawMessage | None = None  # where rospy has not taken it apart


class HumanTopics:
    """Listens to what there is of ``/humans/...``.

    Args:
        put: takes each message, in a thread of ROS; fills in when it came.

    Raises:
        MissingExtraError: rosbags is not installed.
    """

    def __init__(self, put: Callable[[Heard], None]) -> None:
        try:
            from rosbags import typesys
        except ImportError as error:
            raise MissingExtraError("ROS4HRI on ROS 1", "bags", "rosbags") from error
        self.refused: dict[str, str] = {}  # types that cannot be read, and what to tell of them
        self._typesys = typesys
        self._rospy = rospy = ros_module("rospy")
        self._master = ros_module("rosgraph").Master(rospy.get_name())
        self._put = put
        self._topics: dict[str, Any] = {}  # by name
        self._stores: dict[str, Any] = {}  # type stores by md5 sum

    def follow(self) -> None:
        """Listen to topics that are new, and no more to those that have gone.

        A topic on which somebody is connected has not gone: a master that was started again knows
        only of those who have registered since.
        """
        try:
            offered = {topic for topic, _ in self._master.getPublishedTopics("/humans")}
        except master_errors():
            return  # what is connected goes on
        wanted = {topic for topic in offered if HumansLog.wanted(topic)} - {TRANSFORMS, STATIC}
        for topic in wanted - self._topics.keys():
            self._topics[topic] = self._rospy.Subscriber(
                topic, self._rospy.AnyMsg, self._came, topic, queue_size=_WAITING, buff_size=_READ
            )
        for topic in self._topics.keys() - wanted:
            if not self._topics[topic].get_num_connections():
                self._topics.pop(topic).unregister()

    def _came(self, raw: Any, topic: str) -> None:
        header = raw._connection_header
        told = RawMessage(
            header["type"], header["md5sum"], header["message_definition"], bytes(raw._buff)
        )
        try:
            if told.md5 not in self._stores:
                store = self._typesys.get_typestore(self._typesys.Stores.EMPTY)
                store.register(self._typesys.get_types_from_msg(told.text, told.name))
                self._stores[told.md5] = store
            message = self._stores[told.md5].deserialize_ros1(told.data, told.name)
        except Exception:  # what others define and send can make a parser raise anything
            self.refused.setdefault(
                told.kind,
                f"Messages of {topic} do not fit the definition of {told.kind} that their"
                " publisher sends; they are left out.",
            )
            return
        self._put(Heard(topic, topic, message, raw=told))
