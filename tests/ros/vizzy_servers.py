"""Servers that behave like Vizzy's, in a process of their own: vizzy_servers.py [BEHAVIOUR].

obey    takes every goal, tells feedback, and does it
abort   takes every goal, and gives up
refuse  rejects every goal
"""

from __future__ import annotations

import math
import sys
import threading
import time

from kendon.geometry import Pose2D, quaternion_yaw, wrap_angle, yaw_quaternion
from kendon.ros.ros1.connection import start_node
from kendon.ros.ros1.environment import messages, ros_module

#: How long each action takes [s], and how often its server looks around.
SECONDS, STEP = 0.3, 0.02


class Base:
    """Drives in a straight line to where it is told, and tells where it is."""

    def __init__(self) -> None:
        rospy = ros_module("rospy")
        self.located = ros_module("geometry_msgs.msg").PoseWithCovarianceStamped
        self.told = rospy.Publisher("amcl_pose", self.located, queue_size=1, latch=True)
        self.pose = Pose2D(0.0, 0.0, 0.0)
        self.tell()

    def tell(self) -> None:
        message = self.located()
        message.header.stamp = ros_module("rospy").Time.now()
        message.header.frame_id = "map"
        position, orientation = message.pose.pose.position, message.pose.pose.orientation
        position.x, position.y = self.pose.x, self.pose.y
        _, _, orientation.z, orientation.w = yaw_quaternion(self.pose.yaw)
        self.told.publish(message)

    def toward(self, start: Pose2D, goal: Pose2D, share: float) -> None:
        self.pose = Pose2D(
            start.x + share * (goal.x - start.x),
            start.y + share * (goal.y - start.y),
            wrap_angle(start.yaw + share * wrap_angle(goal.yaw - start.yaw)),
        )
        self.tell()


class Server:
    """One action server; `steps` does a part of the goal."""

    def __init__(self, name: str, action: object, behaviour: str, base: Base | None) -> None:
        self.behaviour, self.base = behaviour, base
        self.server = ros_module("actionlib").ActionServer(
            name, action, self.goal, self.cancel, auto_start=False
        )
        self.feedback = type(action().action_feedback.feedback)  # type: ignore[operator]
        self.running: object = None
        self.server.start()

    def goal(self, handle: object) -> None:
        if self.behaviour == "refuse":
            handle.set_rejected(text="not today")  # type: ignore[attr-defined]
            return
        handle.set_accepted()  # type: ignore[attr-defined]
        old, self.running = self.running, handle
        if old is not None:
            old.set_canceled(text="preempted")  # type: ignore[attr-defined]
        threading.Thread(target=self.carry_out, args=(handle,), daemon=True).start()

    def cancel(self, handle: object) -> None:
        if handle is self.running or handle == self.running:
            self.running = None
            handle.set_canceled()  # type: ignore[attr-defined]

    def carry_out(self, handle: object) -> None:
        start = self.base.pose if self.base else None
        steps = math.ceil(SECONDS / STEP)
        for step in range(1, steps + 1):
            time.sleep(STEP)
            if self.running is not handle:
                return
            handle.publish_feedback(self.feedback())  # type: ignore[attr-defined]
            if self.base and start:
                target = handle.get_goal().target_pose.pose  # type: ignore[attr-defined]
                q = target.orientation
                yaw = quaternion_yaw((q.x, q.y, q.z, q.w))
                goal = Pose2D(target.position.x, target.position.y, yaw)
                self.base.toward(start, goal, step / steps)
            if self.behaviour == "abort" and step > 3:
                break
        self.running = None
        if self.behaviour == "abort":
            handle.set_aborted(text="the way is barred")  # type: ignore[attr-defined]
        else:
            handle.set_succeeded()  # type: ignore[attr-defined]


def main(behaviour: str) -> None:
    start_node("vizzy_servers")
    rospy, standard = ros_module("rospy"), ros_module("std_msgs.msg")
    servers = [
        Server("move_base", ros_module("move_base_msgs.msg").MoveBaseAction, behaviour, Base()),
        Server("gaze", messages("vizzy_msgs").GazeAction, behaviour, None),
        Server("gcloud_tts", messages("woz_dialog_msgs").SpeechAction, behaviour, None),
    ]
    heard = rospy.Publisher("arms_heard", standard.Int16, queue_size=10)
    rospy.Subscriber("vizzyArmRoutines/command", standard.Int16, heard.publish)
    rospy.Subscriber("expression", standard.String, lambda message: None)
    print("ready", len(servers), flush=True)
    sys.stdin.read()  # until the one who started it closes the pipe or dies
    rospy.signal_shutdown("the tests end")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "obey")
