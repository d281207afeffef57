"""Vizzy, the thesis's robot (3.6.2), by its ROS 1 interface.

move_base (action move_base_msgs/MoveBase)     drives and turns the base
gaze (action vizzy_msgs/Gaze)                  points the head at a point
gcloud_tts (action woz_dialog_msgs/Speech)     speaks
vizzyArmRoutines/command (std_msgs/Int16)      performs arm routines, which tell nothing back
expression (std_msgs/String)                   shows an expression, by its name; kendon's own
amcl_pose, /tf                                 where it is
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from kendon.errors import RobotError
from kendon.features import ROBOT_FACE
from kendon.geometry import Pose2D, Vec3, yaw_quaternion
from kendon.robots.base import CHANNELS, Command, CommandKind, Robot
from kendon.robots.point import EXPRESSION_SECONDS, GESTURE_SECONDS
from kendon.ros.ros1.actions import ActionLink, Goal
from kendon.ros.ros1.environment import messages, ros_module
from kendon.sources.ros_place import RobotPlace

#: The numbers of Vizzy's arm routines.
ARM_ROUTINES: Mapping[str, int] = {
    "home": 0, "wave": 1, "stretch": 2, "handshake": 3, "ask_handshake": 4, "handshake_pid": 5,
    "arms_down": 6, "happy_emotionless": 7, "happy_emotive": 8, "sad": 9, "angry": 10, "fear": 11,
}  # fmt: skip
#: How long a routine takes of which kendon knows no better [s].
_ROUTINE_SECONDS = 4.0
#: The languages and voices of Vizzy's speech server, by BCP 47's language.
VOICES: Mapping[str, tuple[str, str]] = {
    "pt": ("pt_PT", "pt-PT-Wavenet-D"),
    "en": ("en_US", "en-US-Wavenet-D"),
}
#: How far the head may miss the point [m], as Vizzy's own trees have it.
GAZE_TOLERANCE = 0.05


class Vizzy(Robot):
    """Vizzy, in a process that is a ROS 1 node already.

    A command that no server takes is refused. A server that falls silent fails its command within
    `patience`. Arm routines and expressions tell nothing back: they count as done after the time
    they take, while somebody listens.

    Args:
        place: where the robot is, if somebody else keeps it up to date.
        face: the robot's face in its base frame [m].
        patience: how long a command may run without a sign of life from the robot [s].

    Raises:
        RosMissingError: ROS 1 is not installed.
        ParameterError: patience is not positive.
    """

    gestures = tuple(ARM_ROUTINES)

    def __init__(
        self, place: RobotPlace | None = None, *, face: Vec3 = ROBOT_FACE, patience: float = 5.0
    ) -> None:
        super().__init__(patience=patience)
        self._rospy = rospy = ros_module("rospy")
        self._face = face
        self.place = place or RobotPlace()
        if place is None:
            follow_robot(self.place)
        standard = ros_module("std_msgs.msg")
        self._geometry = ros_module("geometry_msgs.msg")
        self._move = ros_module("move_base_msgs.msg")
        self._vizzy, self._speech = messages("vizzy_msgs"), messages("woz_dialog_msgs")
        self._base = ActionLink("move_base", self._move.MoveBaseAction)
        self._head = ActionLink("gaze", self._vizzy.GazeAction)
        self._voice = ActionLink("gcloud_tts", self._speech.SpeechAction)
        self._arms = rospy.Publisher("vizzyArmRoutines/command", standard.Int16, queue_size=5)
        self._expression = rospy.Publisher("expression", standard.String, queue_size=5)
        self._goals: dict[Command, tuple[ActionLink, Goal]] = {}
        self._leaving: list[Goal] = []  # cancelled or replaced, and not yet told to be over
        self._coming: str | None = None  # the channel of the command that is about to be sent
        self._until: dict[Command, float] = {}  # [s], when what tells nothing back is done

    @property
    def pose(self) -> Pose2D:
        """The pose of the base in the world; the origin as long as nobody tells it."""
        return self.place.pose

    @property
    def face(self) -> Vec3:
        """The robot's face in its base frame [m]."""
        return self._face

    def missing(self, seconds: float = 0.0) -> list[str]:
        """The parts of the robot that nobody answers for, after waiting for them [s]."""
        parts: dict[str, Callable[[], bool]] = {
            link.name: lambda link=link: link.connected  # type: ignore[misc]
            for link in (self._base, self._head, self._voice)
        }
        for publisher in (self._arms, self._expression):
            parts[publisher.resolved_name] = lambda p=publisher: p.get_num_connections() > 0  # type: ignore[misc]
        deadline = time.monotonic() + seconds
        while True:
            absent = [name for name, there in parts.items() if not there()]
            if not absent or time.monotonic() >= deadline:
                return absent
            time.sleep(0.05)

    # ---- the hooks

    def _issue(self, kind: CommandKind, **asked: Any) -> Command:
        self._coming = CHANNELS[kind]
        try:
            return super()._issue(kind, **asked)
        finally:
            self._coming = None

    def _send(self, command: Command) -> dict[str, Any]:
        asked = command.asked
        match command.kind:
            case CommandKind.GO_TO:
                self._drive(command, asked["goal"])
            case CommandKind.TURN_TO:
                here = self.pose
                self._drive(command, Pose2D(here.x, here.y, asked["yaw"]))
            case CommandKind.LOOK_AT:
                self._start(command, self._head, self._gaze_goal(asked["point"]))
            case CommandKind.SAY:
                return self._speak(command)
            case CommandKind.GESTURE:
                self._publish(self._arms, ARM_ROUTINES[asked["name"]])
                seconds = GESTURE_SECONDS.get(asked["name"], _ROUTINE_SECONDS)
                self._until[command] = self.time + seconds
                return {**asked, "routine": ARM_ROUTINES[asked["name"]]}
            case CommandKind.EXPRESS:
                self._publish(self._expression, asked["expression"])
                self._until[command] = self.time + EXPRESSION_SECONDS
            case CommandKind.STOP:
                for link in (self._base, self._head, self._voice):
                    link.cancel_all()
        return dict(asked)

    def _abort(self, command: Command) -> None:
        self._until.pop(command, None)
        replaced = self._coming == CHANNELS[command.kind]
        if command in self._goals:
            link, goal = self._goals.pop(command)
            self._leaving.append(goal)
            # A server ends its goal for the next one by itself; told to, a base would brake first.
            if not (replaced and link.connected):
                link.cancel(goal)
        elif command.kind is CommandKind.GESTURE and command.asked["name"] != "home":
            if replaced:  # likewise: the next routine moves the arms from wherever they are
                return
            self._publish(self._arms, ARM_ROUTINES["home"])

    def _advance(self, dt: float) -> None:
        del dt
        for command, (link, goal) in list(self._goals.items()):
            if goal.take_heard():
                self.hear(command)
            if goal.over:
                del self._goals[command]
                if link.swept(goal) and link.connected:
                    self._start(command, link, goal.asked)  # the stop was meant for those before
                else:
                    self._finish(command, goal)
        for command, until in list(self._until.items()):
            self._wait(command, until)
        self._leaving = [goal for goal in self._leaving if not self._gone(goal)]
        stop = self.running(CommandKind.STOP)
        if stop and not self._leaving:
            self.succeed(stop)

    # ---- how each is done

    def _drive(self, command: Command, goal: Pose2D) -> None:
        target = self._move.MoveBaseGoal()
        target.target_pose.header.frame_id = self.place.world
        target.target_pose.header.stamp = self._rospy.Time.now()
        pose = target.target_pose.pose
        pose.position.x, pose.position.y = goal.x, goal.y
        _, _, pose.orientation.z, pose.orientation.w = yaw_quaternion(goal.yaw)
        self._start(command, self._base, target)

    def _gaze_goal(self, point: Vec3) -> Any:
        goal = self._vizzy.GazeGoal()
        goal.type, goal.mode = goal.FIXATION_POINT, goal.CARTESIAN
        # Without a stamp, as of now; in the base frame, which is there without localisation, too.
        goal.fixation_point.header.frame_id = self.place.bases[0]
        local = self.pose.to_local(point)
        goal.fixation_point.point.x, goal.fixation_point.point.y = local[0], local[1]
        goal.fixation_point.point.z = local[2]
        goal.fixation_point_error_tolerance = GAZE_TOLERANCE
        return goal

    def _speak(self, command: Command) -> dict[str, Any]:
        asked = command.asked
        language, voice = VOICES.get(asked["language"].split("-")[0], (asked["language"], ""))
        goal = self._speech.SpeechGoal(language=language, voice=voice, message=asked["text"])
        goal.speed = goal.MEDIUM
        self._start(command, self._voice, goal)
        return {"text": asked["text"], "language": language, "voice": voice}

    def _start(self, command: Command, link: ActionLink, goal: Any) -> None:
        self._goals[command] = link, link.send(goal)

    def _publish(self, publisher: Any, data: Any) -> None:
        if publisher.get_num_connections() == 0:
            raise RobotError(f"nobody listens to {publisher.resolved_name}")
        publisher.publish(data)

    def _finish(self, command: Command, goal: Goal) -> None:
        status = ros_module("actionlib_msgs.msg").GoalStatus
        said = f": {goal.text}" if goal.text else ""
        reasons = {
            status.ABORTED: f"the robot gave up{said}",
            status.REJECTED: f"the robot refused{said}",
            status.PREEMPTED: "another node has taken over",
            status.RECALLED: "another node has taken over",
            status.LOST: "the robot knows no more of it",
        }
        if goal.status == status.SUCCEEDED:
            self.succeed(command)
        else:
            self.fail(
                command, reasons.get(goal.status, f"it ended with status {goal.status}{said}")
            )

    def _wait(self, command: Command, until: float) -> None:
        """Let time pass for a command of which the robot tells nothing back."""
        part = self._arms if command.kind is CommandKind.GESTURE else self._expression
        listened = part.get_num_connections() > 0
        if listened:
            self.hear(command)
        if self.time >= until - 1e-9:  # a sum of time steps may fall short by rounding
            del self._until[command]
            if listened:
                self.succeed(command)
            else:
                self.fail(command, f"nobody listens to {part.resolved_name} any more")

    def _gone(self, goal: Goal) -> bool:
        """Whether a cancelled goal is over; a sign of life of it is one of the stop."""
        stop = self.running(CommandKind.STOP)
        if goal.take_heard() and stop:
            self.hear(stop)
        return goal.over


def follow_robot(place: RobotPlace) -> None:
    """Keep a place up to date from the localisation's pose and the frames of TF."""
    rospy = ros_module("rospy")
    transforms = ros_module("tf2_msgs.msg").TFMessage
    located = ros_module("geometry_msgs.msg").PoseWithCovarianceStamped
    rospy.Subscriber("/tf", transforms, place.take_transforms, queue_size=100)
    rospy.Subscriber("/tf_static", transforms, lambda m: place.take_transforms(m, static=True))
    rospy.Subscriber("amcl_pose", located, place.take_localised, queue_size=10)
