"""The walking person of Algorithm 2, in Gazebo: a model that is put a little further each time."""

from __future__ import annotations

import math
from collections.abc import Iterator

from kendon.errors import KendonError, ParameterError, RobotError
from kendon.geometry import Pose2D, yaw_quaternion
from kendon.ros.ros1.environment import messages, ros_module

#: The thesis's model, the service that moves it, and its stations a second (Algorithm 2).
MODEL, SERVICE, STATIONS = "pessoa1", "/gazebo/set_model_state", 10.0
#: How long Gazebo may take to be there, and to answer [s].
_ANSWERS = 5.0


def stations(start: Pose2D, goal: Pose2D, speed: float) -> list[Pose2D]:
    """The places of a walk, a tenth of a second apart, the goal the last (Algorithm 2).

    The person looks the way they walk.

    Args:
        start: where the walk begins.
        goal: where it ends.
        speed: of the walk [m/s].

    Raises:
        ParameterError: the speed is not positive.
    """
    if not 0 < speed < math.inf:
        raise ParameterError(f"the speed of a walk is a positive number of m/s, not {speed:g}")
    count = max(1, round(STATIONS * start.distance_to(goal) / speed))
    yaw = math.atan2(goal.y - start.y, goal.x - start.x)
    return [
        Pose2D(
            start.x + i / count * (goal.x - start.x), start.y + i / count * (goal.y - start.y), yaw
        )
        for i in range(count + 1)
    ]


class GazeboPerson:
    """A model of a person in Gazebo.

    Args:
        model: its name there.
        service: what moves models.

    Raises:
        RosMissingError: ROS 1 is not installed.
        KendonError: nobody offers the service.
    """

    def __init__(self, model: str = MODEL, service: str = SERVICE) -> None:
        self._rospy = rospy = ros_module("rospy")
        self._gazebo = messages("gazebo_msgs")
        self.model = model
        name = rospy.resolve_name(service)
        try:
            rospy.wait_for_service(name, timeout=_ANSWERS)
        except rospy.ROSException:
            raise KendonError(
                f"nobody offers the service {name}; start Gazebo with its ROS plugin"
                " (roslaunch gazebo_ros empty_world.launch)"
            ) from None
        self._move = rospy.ServiceProxy(name, self._gazebo.SetModelState, persistent=True)

    def put(self, place: Pose2D) -> None:
        """Put the person somewhere in the world, on the floor.

        Raises:
            RobotError: Gazebo does not, or has gone.
        """
        state = self._gazebo.ModelState(model_name=self.model, reference_frame="world")
        state.pose.position.x, state.pose.position.y = place.x, place.y
        _, _, state.pose.orientation.z, state.pose.orientation.w = yaw_quaternion(place.yaw)
        try:
            answer = self._move(state)
        except (self._rospy.ServiceException, OSError) as error:
            raise RobotError(f"Gazebo does not answer: {error}") from None
        if not answer.success:
            raise RobotError(f"Gazebo does not move {self.model!r}: {answer.status_message}")

    def walk(self, start: Pose2D, goal: Pose2D, speed: float) -> Iterator[Pose2D]:
        """Walk, and tell each place when the person is there.

        Raises:
            ParameterError: the speed is not positive.
            RobotError: Gazebo does not move the person, or has gone.
        """
        rate = self._rospy.Rate(STATIONS)  # of simulated time, where there is one
        for place in stations(start, goal, speed):
            self.put(place)
            yield place
            rate.sleep()
