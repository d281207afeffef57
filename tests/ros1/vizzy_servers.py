"""Servers that behave like Vizzy's, in a process of their own.

    python vizzy_servers.py [BEHAVIOUR [PART...]]

obey    takes every goal, tells feedback, and does it after a while
abort   takes every goal, and gives up
refuse  rejects every goal
ideal   does what the robot with ideal kinematics does, in its time, and prints what it was told
rooted  likewise, but only turns in place

The parts are move_base, gaze, gcloud_tts and arms; all of them if none is named.
"""

from __future__ import annotations

import json
import math
import queue
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from kendon.geometry import Pose2D, Vec3, quaternion_yaw, wrap_angle, yaw_quaternion
from kendon.robots import PointRobot
from kendon.robots.base import Command, CommandStatus
from kendon.ros.ros1.connection import start_node
from kendon.ros.ros1.environment import messages, ros_module
from kendon.ros.ros1.vizzy import ARM_ROUTINES

#: How long each action takes [s], and how often its server looks around.
SECONDS, STEP = 0.3, 0.02
PARTS = ("move_base", "gaze", "gcloud_tts", "arms")
_PRINTING = threading.Lock()


class Base:
    """Where the robot is, told on /amcl_pose."""

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


def target(goal: Any) -> Pose2D:
    """The pose of a goal of move_base."""
    pose = goal.target_pose.pose
    q = pose.orientation
    return Pose2D(pose.position.x, pose.position.y, quaternion_yaw((q.x, q.y, q.z, q.w)))


class Server:
    """One action server."""

    def __init__(self, name: str, action: Any, behaviour: str, base: Base | None) -> None:
        self.name, self.behaviour, self.base = name, behaviour, base
        self.running: Any = None
        self.feedback = type(action().action_feedback.feedback)
        self.server = ros_module("actionlib").ActionServer(
            name, action, self.goal, self.cancel, auto_start=False
        )
        self.server.start()

    def goal(self, handle: Any) -> None:
        if self.behaviour == "refuse":
            handle.set_rejected(text="not today")
            return
        handle.set_accepted()
        old, self.running = self.running, handle
        if old is not None:
            old.set_canceled(text="preempted")
        self.begin(handle)

    def cancel(self, handle: Any) -> None:
        if self.is_running(handle):
            self.running = None
            handle.set_canceled()

    def is_running(self, handle: Any) -> bool:
        """Whether a goal is the one under way; actionlib's handles cannot be compared with None."""
        return self.running is not None and bool(handle == self.running)

    def begin(self, handle: Any) -> None:
        threading.Thread(target=self.carry_out, args=(handle,), daemon=True).start()

    def carry_out(self, handle: Any) -> None:
        start = self.base.pose if self.base else None
        steps = math.ceil(SECONDS / STEP)
        for step in range(1, steps + 1):
            time.sleep(STEP)
            if self.running is not handle:
                return
            handle.publish_feedback(self.feedback())
            if self.base and start:
                self.base.toward(start, target(handle.get_goal()), step / steps)
            if self.behaviour == "abort" and step > 3:
                break
        self.running = None
        if self.behaviour == "abort":
            handle.set_aborted(text="the way is barred")
        else:
            handle.set_succeeded()


class IdealBody:
    """The robot with ideal kinematics, by the wall's clock; all its servers move this one."""

    def __init__(self, base: Base | None, leash: float | None) -> None:
        self.base = base
        self.robot = PointRobot(leash=leash)
        self.began = time.monotonic()
        # By one thread: an action server holds a lock of its own while it tells of goals.
        self.asked: queue.Queue[Callable[[], None]] = queue.Queue()
        self.servers: list[IdealServer] = []
        self.person: Vec3 | None = None  # in the world; a base has sensors of its own
        ros_module("rospy").Subscriber("faces", messages("kendon_msgs").FaceExtraction, self.see)
        threading.Thread(target=self.live, daemon=True).start()

    def see(self, message: Any) -> None:
        face = message.face
        self.person = self.robot.pose.to_world((face.x, face.y, face.z))

    def live(self) -> None:
        while True:
            self.robot.person = self.person
            with suppress(queue.Empty):
                self.asked.get(timeout=STEP)()
            self.robot.update(time.monotonic() - self.began)
            for server in self.servers:
                server.look_around()
            if self.base and self.base.pose != self.robot.pose:
                self.base.pose = self.robot.pose
                self.base.tell()


class IdealServer(Server):
    """Does what the ideal body does."""

    def __init__(self, name: str, action: Any, body: IdealBody) -> None:
        self.body = body
        self.command: Command | None = None
        super().__init__(name, action, "ideal", None)
        body.servers.append(self)

    def goal(self, handle: Any) -> None:
        self.body.asked.put(lambda: self.start(handle))

    def start(self, handle: Any) -> None:
        super().goal(handle)

    def cancel(self, handle: Any) -> None:
        self.body.asked.put(lambda: self.end(handle))

    def end(self, handle: Any) -> None:
        if self.is_running(handle) and self.command is not None:
            self.command.cancel()
            tell("cancel", self.name)
        super().cancel(handle)

    def begin(self, handle: Any) -> None:
        goal, robot = handle.get_goal(), self.body.robot
        if self.name == "move_base":
            pose = target(goal)
            turns = pose.distance_to(robot.pose) < 1e-3
            self.command = robot.turn_to(pose.yaw) if turns else robot.go_to(pose)
            tell("turn_to" if turns else "go_to", list(pose))
        elif self.name == "gaze":
            point = goal.fixation_point.point
            place = robot.pose.to_world((point.x, point.y, point.z))
            self.command = robot.look_at(place)
            tell("look_at", list(place))
        else:
            self.command = robot.say(goal.message)
            tell("say", goal.message)
        self.look_around()

    def look_around(self) -> None:
        if self.running is None or self.command is None or self.command.running:
            return
        handle, self.running = self.running, None
        if self.command.status is CommandStatus.SUCCEEDED:
            handle.set_succeeded()
        else:
            handle.set_aborted(text=self.command.reason)


def tell(kind: str, what: object) -> None:
    """Print what came, for those who started this process."""
    now = ros_module("rospy").get_time()
    with _PRINTING:
        print(json.dumps({"t": now, "kind": kind, "what": what}), flush=True)


def main(behaviour: str, parts: list[str]) -> None:
    start_node("_".join(["vizzy", *parts]) if parts else "vizzy_servers")
    parts = parts or list(PARTS)
    rospy, standard = ros_module("rospy"), ros_module("std_msgs.msg")
    base = Base() if "move_base" in parts else None
    leashes = {"ideal": None, "rooted": 0.0}
    body = IdealBody(base, leashes[behaviour]) if behaviour in leashes else None
    actions: dict[str, Callable[[], Any]] = {
        "move_base": lambda: ros_module("move_base_msgs.msg").MoveBaseAction,
        "gaze": lambda: messages("vizzy_msgs").GazeAction,
        "gcloud_tts": lambda: messages("woz_dialog_msgs").SpeechAction,
    }
    servers = [
        IdealServer(name, action(), body)
        if body
        else Server(name, action(), behaviour, base if name == "move_base" else None)
        for name, action in actions.items()
        if name in parts
    ]
    if "arms" in parts:
        heard = rospy.Publisher("arms_heard", standard.Int16, queue_size=10)
        routines = {number: name for name, number in ARM_ROUTINES.items()}

        def arms(message: Any) -> None:
            heard.publish(message)
            if body:
                tell("gesture", routines[message.data])

        def face(message: Any) -> None:
            if body:
                tell("express", message.data)

        rospy.Subscriber("vizzyArmRoutines/command", standard.Int16, arms)
        rospy.Subscriber("expression", standard.String, face)
    with _PRINTING:
        print("ready", len(servers), flush=True)
    sys.stdin.read()  # until the one who started it closes the pipe or dies
    rospy.signal_shutdown("the tests end")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "obey", sys.argv[2:])
