"""Tells of a person on ``/faces`` (kendon_msgs/FaceExtraction, thesis 3.3)."""

from __future__ import annotations

import time

from kendon.person import PersonFrame
from kendon.ros.ros1.connection import flush
from kendon.ros.ros1.environment import messages, ros_module
from kendon.sources.ros_faces import fill_face
from kendon.sources.ros_place import BASES


class FacePublisher:
    """Publishes the frames of one person, stamped as they are told.

    In a process that is a ROS 1 node already.
    """

    def __init__(self) -> None:
        self._rospy = rospy = ros_module("rospy")
        self._kind = messages("kendon_msgs").FaceExtraction
        self._point = ros_module("geometry_msgs.msg").Point
        self._faces = rospy.Publisher("faces", self._kind, queue_size=50, tcp_nodelay=True)
        self.topic: str = self._faces.resolved_name

    def awaited(self, seconds: float) -> bool:
        """Whether somebody reads it, within so long [s]."""
        deadline = time.monotonic() + seconds
        while not self._faces.get_num_connections() and time.monotonic() < deadline:
            time.sleep(0.02)
        return bool(self._faces.get_num_connections())

    def tell(self, frame: PersonFrame) -> None:
        """Tell of the person, in the robot's base frame."""
        message = fill_face(self._kind(), frame, self._point)
        message.header.stamp = self._rospy.Time.now()
        message.header.frame_id = BASES[0]
        self._faces.publish(message)

    def close(self) -> None:
        """See that all that was told is on its way."""
        flush(seconds=1.0)
