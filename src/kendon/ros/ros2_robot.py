"""A robot of ROS 2 as most have it: a base behind Nav2 or ros2_control, and topics for the rest.

Where it is is heard (odometry or TF). Topics tell nothing back, so commands on the head, arms,
voice and face end after the time that they take, as long as somebody reads their topic.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from typing import Any

from kendon.errors import KendonError, RobotError
from kendon.geometry import Pose2D, Vec3, wrap_angle
from kendon.robots.base import CHANNELS, Command, CommandKind, Robot
from kendon.robots.drive import UnicycleBase
from kendon.robots.driving import Driving
from kendon.robots.point import EXPRESSION_SECONDS, GESTURE_SECONDS, SPEECH_RATE
from kendon.ros.ros2_settings import Drive, HeardPlace, Ros2Settings
from kendon.ros.ros2_transport import Fields, Transport
from kendon.ros.ros2_types import STRING, header_fields, stamp_fields

POSE = "geometry_msgs/msg/PoseStamped"
POINT = "geometry_msgs/msg/PointStamped"
TWIST = "geometry_msgs/msg/Twist"
TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"

#: How long a head takes to look somewhere else [s]; chosen: half a turn at 2 rad/s, and some.
LOOK_SECONDS = 1.0
#: A base that moves less than this in `STILL_SECONDS` stands [m, rad].
STILL = 1e-3
STILL_SECONDS = 0.3
#: A drive in which the base stands for so long away from its goal has failed [s].
STUCK_SECONDS = 10.0
#: A robot that has told nothing of itself for so long may be gone [s].
SILENT_SECONDS = 1.0
#: Before a drive has begun, standing is no arrival [s]: a planner takes its time.
STARTS_WITHIN = 1.0


class Ros2Robot(Robot):
    """A robot that is told what to do on topics.

    Args:
        transport: carries them; who drives the flow also spins it.
        place: told where the robot is.
        settings: what is known of it.
        clock: the time that messages are stamped with [ns].
        patience: see `Robot`.
    """

    def __init__(
        self,
        transport: Transport,
        place: HeardPlace,
        settings: Ros2Settings | None = None,
        *,
        clock: Callable[[], int],
        patience: float = 5.0,
    ) -> None:
        super().__init__(patience=patience)
        self.settings = settings or Ros2Settings()
        self._transport = transport
        self._place = place
        self._clock = clock
        self._driving: Driving | None = None  # from the first known pose on
        self._readers: Mapping[str, str] = {}
        self._until: dict[CommandKind, float] = {}  # [s], when timed commands end
        self._still = (Pose2D(0.0, 0.0, 0.0), 0.0)  # a pose, and since when it has not changed
        self._coming = ""  # the channel of the command that is about to be sent
        self._replaced = False  # whether it takes the place of a drive that goes on until then
        self._told_at = 0.0  # [s], when the base was last told of a goal
        self._odometry = (0, 0.0)  # how many poses were heard, and when the last one was new [s]
        topics = self.settings.topics
        drive = self.settings.drive
        self._topics = {
            CommandKind.LOOK_AT: topics.look,
            CommandKind.GESTURE: topics.gesture,
            CommandKind.SAY: topics.say,
            CommandKind.EXPRESS: topics.express,
        }
        for topic in (topics.gesture, topics.say, topics.express):
            transport.advertise(topic, STRING)
        transport.advertise(topics.look, POINT)
        if drive is Drive.GOAL_POSE:
            transport.advertise(topics.goal, POSE)

    @property
    def pose(self) -> Pose2D:
        """Where the base was last told to be in the world."""
        return self._place.pose

    @property
    def face(self) -> Vec3:
        """The face in the base frame [m]."""
        return self.settings.face

    def close(self) -> None:
        """Stop the base at once; nothing brakes it any more afterwards."""
        if self._driving is not None:
            self._driving.base.aim()
            with contextlib.suppress(RobotError):  # it cannot be told, and nobody is left to hear
                self._halt_now()

    # ---- the hooks of Robot

    def _issue(self, kind: CommandKind, **asked: Any) -> Command:
        self._coming, self._replaced = CHANNELS[kind], False
        try:
            command = super()._issue(kind, **asked)
        finally:
            self._coming = ""
        if self._replaced and not command.running:  # refused, and nobody has stopped the old one
            with contextlib.suppress(RobotError):  # as it was for the new one
                self._stand()
        return command

    def _send(self, command: Command) -> dict[str, Any]:
        kind, asked = command.kind, command.asked
        sent = dict(asked)
        if kind in (CommandKind.GO_TO, CommandKind.TURN_TO):
            driving = self._located()
            sent = driving.send(command, self.person, self.time)
            self._tell_goal(_goal(sent, driving.base))
        elif kind is CommandKind.STOP:
            if self._driving is not None:
                self._stand()
        else:
            self._until[kind] = self.time + self._say(kind, asked)
        return sent

    def _abort(self, command: Command) -> None:
        if CHANNELS[command.kind] != CHANNELS[CommandKind.GO_TO]:
            return
        # A new goal replaces the old one by itself; told to stand first, a base would stutter.
        self._replaced = self._coming == CHANNELS[command.kind]
        if not self._replaced:
            self._stand()

    def _advance(self, dt: float) -> None:
        self._readers = self._transport.asked()
        self._locate()
        if self._driving is not None and self.settings.drive is Drive.CMD_VEL:
            try:
                self._steer(self._driving, dt)
            except RobotError as trouble:
                for kind in (CommandKind.GO_TO, CommandKind.TURN_TO, CommandKind.STOP):
                    if command := self.running(kind):
                        self.fail(command, str(trouble))
        for command in list(self._occupied.values()):
            if not command.running:
                continue
            if command.kind in self._topics:
                self._follow_topic(command)
            else:
                self._follow_base(command)

    # ---- the base

    def _located(self) -> Driving:
        """What drives the base from where it was last told to be.

        Raises:
            RobotError: that was never told.
        """
        self._locate()
        if self._driving is None:
            raise RobotError("nobody tells where the robot is (odometry, or its base in /tf)")
        return self._driving

    def _locate(self) -> None:
        if not self._place.known:
            return
        pose = self.pose
        if self._driving is None:
            settings = self.settings
            self._driving = Driving(
                pose, settings.limits, settings.keep_distance, settings.leash,
                settings.position_tolerance, settings.yaw_tolerance,
            )  # fmt: skip
            self._still = pose, self.time
        base = self._driving.base
        base.x, base.y, base.yaw = pose
        rest, _ = self._still
        if rest.distance_to(pose) > STILL or abs(wrap_angle(rest.yaw - pose.yaw)) > STILL:
            self._still = pose, self.time
        if self._place.told != self._odometry[0]:
            self._odometry = self._place.told, self.time

    @property
    def _standing_for(self) -> float:
        """For how long the base has not moved [s]."""
        return self.time - max(self._still[1], self._told_at)

    def _steer(self, driving: Driving, dt: float) -> None:
        """One step of the approach controller from where the base really is."""
        base = driving.base
        if base.standing and base.goal is None and base.heading is None:
            if self.running(CommandKind.STOP):
                self._tell_speeds(0.0, 0.0)  # whoever drove it until now
            return
        driving.clearance.observe(self.person, self.time)
        if self.time - self._odometry[1] > STILL_SECONDS:
            self._halt_now()  # blind
            return
        base.advance(dt)
        self._tell_speeds(base.speed, base.turn_rate)

    def _tell_goal(self, goal: Pose2D) -> None:
        self._told_at = self.time
        if self.settings.drive is not Drive.GOAL_POSE:
            return
        pose = {
            "position": {"x": goal.x, "y": goal.y},
            "orientation": {"z": math.sin(goal.yaw / 2), "w": math.cos(goal.yaw / 2)},
        }
        self._tell(self.settings.topics.goal, POSE, {"header": self._header(), "pose": pose})

    def _tell_speeds(self, speed: float, turn_rate: float) -> None:
        twist: Fields = {"linear": {"x": speed}, "angular": {"z": turn_rate}}
        topic = self.settings.topics.velocity
        if self._readers.get(topic) == TWIST_STAMPED:
            stamp = stamp_fields(self._clock())
            header = {"stamp": stamp, "frame_id": self._place.bases[0]}
            self._tell(topic, TWIST_STAMPED, {"header": header, "twist": twist})
        else:
            self._tell(topic, TWIST, twist)

    def _stand(self) -> None:
        """Bring the base to a stand: a goal where it is, or braking."""
        self._located().base.aim()
        self._tell_goal(self.pose)

    def _halt_now(self) -> None:
        base = self._located().base
        base.speed = base.turn_rate = 0.0
        if self.settings.drive is Drive.CMD_VEL:
            self._tell_speeds(0.0, 0.0)
        else:
            self._tell_goal(self.pose)

    def _follow_base(self, command: Command) -> None:
        driving = self._driving
        if driving is None:
            self.succeed(command)  # a stop of what never moved
            return
        base = driving.base
        topics = self.settings.topics
        topic = topics.goal if self.settings.drive is Drive.GOAL_POSE else topics.velocity
        there = topic in self._readers
        if there and self._odometry[1] > command.heard:
            self.hear(command)
        lost = self.time - command.heard
        if lost >= self.patience:
            self._try_abort(command)
            self.fail(command, self._why_lost(topic, lost))
            return
        still = self._standing_for >= STILL_SECONDS
        if command.kind is CommandKind.STOP:
            if still and base.standing:
                self.succeed(command)
            return
        off = 0.0 if command.kind is CommandKind.TURN_TO else base.off_goal
        turned = abs(wrap_angle(_goal(command.sent, base).yaw - base.yaw)) <= base.yaw_tolerance
        near = off <= base.position_tolerance and turned
        begun = self._still[1] > self._told_at or self._standing_for >= STARTS_WITHIN
        if (near and still and begun) or (base.arrived and still):
            driving.arrive(self, command)
        elif self._standing_for >= STUCK_SECONDS:
            self._try_abort(command)
            self.fail(command, f"the robot has stood still for {STUCK_SECONDS:g} s off its goal")

    def _why_lost(self, topic: str, lost: float) -> str:
        if topic in self._readers:
            return f"the robot has not told where it is for {lost:.1f} s"
        return f"nobody has read {self._transport.called(topic)} for {lost:.1f} s"

    # ---- head, arms, voice, face

    def _say(self, kind: CommandKind, asked: Mapping[str, Any]) -> float:
        """Publish a command; how long it will take [s]."""
        topic = self._topics[kind]
        if kind is CommandKind.LOOK_AT:
            x, y, z = asked["point"]
            point = {"x": x, "y": y, "z": z}
            self._tell(topic, POINT, {"header": self._header(), "point": point})
            return LOOK_SECONDS
        if kind is CommandKind.GESTURE:
            self._tell(topic, STRING, {"data": asked["name"]})
            return GESTURE_SECONDS[asked["name"]]
        if kind is CommandKind.SAY:
            self._tell(topic, STRING, {"data": asked["text"]})
            return len(asked["text"]) / SPEECH_RATE
        expression = f"{asked['expression']} {asked['intensity']:g}"
        self._tell(topic, STRING, {"data": expression})
        return EXPRESSION_SECONDS

    def _follow_topic(self, command: Command) -> None:
        topic = self._topics[command.kind]
        # A process that dies stays in DDS's books for seconds; the base's motion is told till then.
        moving = self._driving is None or self._odometry[1] > command.heard
        if topic in self._readers and moving:
            self.hear(command)
        lost = self.time - command.heard
        if self.time >= self._until[command.kind] - 1e-9 and lost < SILENT_SECONDS:
            self.succeed(command)
        elif lost >= self.patience:
            self.fail(command, self._why_lost(topic, lost))

    def _header(self) -> Fields:
        return header_fields(self._clock(), self.settings.world or self._place.world or "map")

    def _tell(self, topic: str, kind: str, fields: Fields) -> None:
        try:
            self._transport.publish(topic, kind, fields)
        except KendonError as error:
            raise RobotError(str(error)) from None


def _goal(sent: Mapping[str, Any], base: UnicycleBase) -> Pose2D:
    """Where a drive or a turn is to end."""
    goal: Pose2D = sent.get("goal") or Pose2D(base.x, base.y, sent.get("yaw", 0.0))
    return goal
