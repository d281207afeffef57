"""Publishes what rviz shows, on ``kendon_markers`` (visualization_msgs/MarkerArray)."""

from __future__ import annotations

from typing import Any

from kendon.greeter import Moment
from kendon.robots.base import Robot
from kendon.ros.markers import fill_marker, shapes
from kendon.ros.ros1.environment import ros_module
from kendon.sources.ros_place import RobotPlace


class MarkerPublisher:
    """Shows a greeting in rviz; works only while somebody looks.

    Args:
        robot: who answers.
        place: where it is, and what its frames are called.
    """

    def __init__(self, robot: Robot, place: RobotPlace) -> None:
        self._rospy = ros_module("rospy")
        self._messages = ros_module("visualization_msgs.msg")
        self._point = ros_module("geometry_msgs.msg").Point
        self._robot, self._place = robot, place
        self._shown: set[tuple[str, int]] = set()
        self._topic = self._rospy.Publisher(
            "kendon_markers", self._messages.MarkerArray, queue_size=2
        )

    def show(self, moment: Moment) -> None:
        """Show a moment; what has gone is deleted."""
        if self._topic.get_num_connections() == 0:
            return
        markers = []
        for shape in shapes(moment, self._robot):
            marker = fill_marker(self._messages.Marker(), shape, self._point)
            marker.header.frame_id = self._place.world if shape.in_world else self._place.bases[0]
            markers.append(marker)
        now = {(marker.ns, marker.id) for marker in markers}
        markers += [self._deleted(*name) for name in sorted(self._shown - now)]
        self._shown = now
        self._topic.publish(self._messages.MarkerArray(markers))

    def _deleted(self, name: str, number: int) -> Any:
        marker = self._messages.Marker(ns=name, id=number, action=self._messages.Marker.DELETE)
        marker.header.frame_id = self._place.bases[0]
        return marker
