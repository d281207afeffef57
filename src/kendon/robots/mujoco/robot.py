"""MujocoRobot: a robot whose body obeys physics, simulated as the flow's time advances.

    robot = MujocoRobot()          # Vizzy
    wave = robot.gesture("wave")
    robot.update(4.5)              # 4.5 s of physics

Time is cut into control cycles of 25 ms. In each one the base's plan (the same as PointRobot's,
`kendon.robots.drive`) moves on and the body is steered after it; gestures, head, eyes and
expressions move their set-points; then the physics makes five steps. It is deterministic: the
same calls give the same motion, to the last bit.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kendon.errors import RobotError
from kendon.geometry import ORIGIN, Pose2D, Vec3, wrap_angle
from kendon.person import FloatArray
from kendon.robots.base import Command, CommandKind, Robot
from kendon.robots.driving import Driving, check
from kendon.robots.mujoco.body import CYCLE, Body
from kendon.robots.mujoco.description import RobotDescription, vizzy
from kendon.robots.mujoco.face import Face
from kendon.robots.mujoco.looking import Looking
from kendon.robots.mujoco.motion import Motion, plan
from kendon.robots.point import EXPRESSION_SECONDS, SPEECH_RATE

#: How the base is steered after its plan, by the law of Kanayama et al. (1990): how fast errors
#: along, across and in heading fade [1/s, 1/m^2, 1/s]. Chosen: within half a second, as gently as
#: the base accelerates; across critically damped at half of full speed.
_ALONG, _ACROSS, _HEADING = 2.0, 16.0, 4.0
#: A base as near to its plan as this is left alone [m, rad].
_NEAR = 1e-3
#: A base slower than this stands [m/s, rad/s].
_STANDING = 2e-3
#: A gesture is over when its joints are as near as this to their last set-points [rad or m].
_ARRIVED = 0.02


class MujocoRobot(Robot):
    """A robot that drives, looks, gestures and smiles in MuJoCo.

    What its commands do is what PointRobot's do, but for this:

    * the body follows its plan a little late (the servos take 0.04 s, the base 0.02 s), and a
      command succeeds when the body is there;
    * **look_at** turns the head and, ahead of it, the eyes;
    * **gesture** plays the keyframes of the robot's file. One that is cancelled or replaced by a
      stop ends at once: cancelled, the arms go home; stopped, they hold still;
    * **stop** succeeds when base and arms stand;
    * **express** moves the face's joints, if it has any.

    Args:
        start: the pose it starts from in the world; the leash is tied there.
        description: the robot; kendon's Vizzy where it is left out.
        keep_distance: how near its centre may drive to the person, ground plane [m].
        leash: how far its centre may get from the start [m]; 0 only turns, None is free.
        position_tolerance: how near to its goal a drive ends [m].
        yaw_tolerance: likewise for the heading [rad].
        speech_rate: how fast it speaks [characters/s].
        patience: see `Robot`; a MujocoRobot always answers.

    Raises:
        ParameterError: an argument is out of its range.
        DataError: the description does not fit its model.
    """

    def __init__(
        self,
        start: Pose2D = ORIGIN,
        *,
        description: RobotDescription | None = None,
        keep_distance: float = 1.0,
        leash: float | None = None,
        position_tolerance: float = 0.05,
        yaw_tolerance: float = 0.02,
        speech_rate: float = SPEECH_RATE,
        patience: float = 5.0,
    ) -> None:
        super().__init__(patience=patience)
        check("speech_rate", speech_rate, "characters/s")
        self.description = description or vizzy()
        self._driving = Driving(
            start, self.description.limits, keep_distance, leash, position_tolerance, yaw_tolerance
        )
        self.body = Body(self.description, Pose2D(*start))
        body = self.body
        self._speech_rate = speech_rate
        self._cycles = 0  # made so far
        self._until: dict[CommandKind, float] = {}  # [s], when timed commands end
        # Where arms and all other joints shall be; of pan and tilt only what gestures add.
        self._posed = body.rest.copy()
        self._posed[[body.pan, body.tilt]] = 0.0
        self._posing = np.zeros(len(body.joints))  # how fast that changes [rad/s or m/s]
        self._motion: Motion | None = None
        self._homeward = False  # whether to go home next, since a gesture was cancelled
        self._read_gestures()
        self._looking = Looking(body, self.description.head)
        self._face = Face(body, self.description.expressions)
        self.expressions = self._face.names
        self._pose = body.pose
        #: What a film needs: times [s] and positions of all joints after each control cycle in
        #: which anything moved. None unless somebody sets a list, which is then added to.
        self.history: list[tuple[float, FloatArray]] | None = None

    # ---- what the robot knows of itself

    @property
    def pose(self) -> Pose2D:
        """The pose of the base in the world."""
        return self._pose

    @property
    def face(self) -> Vec3:
        """The face in the base frame while the robot is at rest [m]."""
        return self.body.face

    @property
    def speed(self) -> float:
        """The base's speed, negative in reverse [m/s]."""
        return self.body.base_speeds[0]

    @property
    def turn_rate(self) -> float:
        """The base's turn rate, positive to the left [rad/s]."""
        return self.body.base_speeds[1]

    @property
    def pan(self) -> float:
        """The head's pan, positive to the left [rad]."""
        return float(self.body.angles[self.body.pan]) * self.body.pan_sign

    @property
    def tilt(self) -> float:
        """The head's tilt, positive up [rad]."""
        return float(self.body.angles[self.body.tilt]) * self.body.tilt_sign

    @property
    def gaze_direction(self) -> Vec3:
        """Where the face points in the world, a unit vector."""
        x, y, z = self.body.sight(self.description.head.face)[1][:, 0].tolist()
        return (x, y, z)

    @property
    def expression(self) -> tuple[str, float]:
        """The expression on the face and its present intensity between 0 and 1."""
        return self._face.expression, self._face.level

    # ---- the hooks of Robot

    def _send(self, command: Command) -> dict[str, Any]:
        kind, asked = command.kind, command.asked
        sent = dict(asked)
        if kind in (CommandKind.GO_TO, CommandKind.TURN_TO):
            sent = self._driving.send(command, self.person, self.time)
        elif kind is CommandKind.LOOK_AT:
            point: Vec3 = asked["point"]
            self._driving.refuse_far("point to look at", *point)
            face = self.body.sight(self.description.head.face)[0].tolist()
            if math.dist(face, point) < 1e-3:
                raise RobotError(f"the point to look at, {point}, lies in the robot's own face")
            self._looking.aim(point)
            self._looking.done = False
            sent["pan"], sent["tilt"] = self._looking.target
        elif kind is CommandKind.GESTURE:
            self._motion, self._homeward = self._plan(asked["name"]), False
        elif kind is CommandKind.SAY:
            self._until[kind] = self.time + len(asked["text"].strip()) / self._speech_rate
        elif kind is CommandKind.EXPRESS:
            self._until[kind] = self.time + EXPRESSION_SECONDS
            self._face.show(asked["expression"], asked["intensity"], self.time)
        else:
            self._motion, self._homeward = None, False
            if self._standing:
                self.succeed(command)
        return sent

    def _abort(self, command: Command) -> None:
        kind = command.kind
        if kind in (CommandKind.GO_TO, CommandKind.TURN_TO):
            self._driving.base.aim()
        elif kind is CommandKind.GESTURE:
            self._motion, self._homeward = None, True

    def _advance(self, dt: float) -> None:
        due = math.floor(self.time / CYCLE + 1e-6)
        while self._cycles < due:
            if self._at_rest:
                # Nothing moves and nothing will: a long wait costs nothing.
                self._cycles = due
                break
            self._cycles += 1
            self._cycle()
        self.body.settle()
        self._pose = self.body.pose
        for command in self._occupied.values():
            if command.running:
                command.heard = self.time
                self._finish(command)

    def _finish(self, command: Command) -> None:
        """End a command that is done; drives end within the cycle in which they are."""
        kind = command.kind
        if kind is CommandKind.LOOK_AT:
            # A base that still turns may yet bring the point within the joints' reach.
            if self._looking.is_at(command.asked["point"], self._posed) and (
                self._looking.reachable or self._driving.base.standing
            ):
                beyond = "the point lies beyond the head's joints"
                self.succeed(command, "" if self._looking.reachable else beyond)
        elif kind is CommandKind.GESTURE:
            self._finish_gesture(command)
        elif kind is CommandKind.STOP:
            if self._standing:
                self.succeed(command)
        elif kind in self._until:
            left = self._until[kind] - self.time
            if kind is CommandKind.EXPRESS:
                self._face.follow(left)
            if left <= 1e-9:  # a sum of time steps may fall short by rounding
                self.succeed(command)

    # ---- one cycle

    def _cycle(self) -> None:
        """Move every plan on by one cycle, and the body after it."""
        base = self._driving.base
        now = self._cycles * CYCLE
        self._driving.clearance.observe(self.person, now)
        before = Pose2D(base.x, base.y, base.yaw)
        base.advance(CYCLE)
        speed, turn_rate = self._steer(before)
        targets = self._next_targets(now)
        self.body.advance(targets, speed, turn_rate)
        if self.history is not None:
            self.history.append((now, self.body.data.qpos.copy()))
        drive = self.running(CommandKind.GO_TO) or self.running(CommandKind.TURN_TO)
        if drive is not None and (not base.standing or self._base_stands):
            self._driving.finish(self, drive)

    def _steer(self, planned: Pose2D) -> tuple[float, float]:
        """The speeds that bring the base onto its plan (Kanayama et al. 1990), within limits."""
        base, limits = self._driving.base, self._driving.base.limits
        here = self.body.pose
        along, across, _ = here.to_local((planned.x, planned.y, 0.0))
        turn = wrap_angle(planned.yaw - here.yaw)
        if base.standing and abs(along) < _NEAR and abs(turn) < _NEAR:
            return 0.0, 0.0
        speed = base.speed * math.cos(turn) + _ALONG * along
        rate = base.turn_rate + _ACROSS * base.speed * across + _HEADING * math.sin(turn)
        return (
            min(max(speed, -limits.speed), limits.speed),
            min(max(rate, -limits.turn_rate), limits.turn_rate),
        )

    def _next_targets(self, now: float) -> FloatArray:
        """Where all joints' set-points shall be after this cycle."""
        if self._homeward:
            self._motion, self._homeward = self._plan("home"), False
        if self._motion is not None:
            points = self._motion.next()
            joints = self._motion.joints
            self._posing[:] = 0.0
            self._posing[joints] = (points - self._posed[joints]) / CYCLE
            self._posed[joints] = points
            if self._motion.over:
                self._motion = None
        elif self._posing.any():
            self._posing[:] = 0.0
        look = self.running(CommandKind.LOOK_AT)
        self._looking.step(None if look is None else look.asked["point"])
        targets = self._posed.copy()
        self._looking.pose(targets)
        self._face.pose(targets, now)
        return targets

    @property
    def _base_stands(self) -> bool:
        speed, turn_rate = self.body.base_speeds
        return abs(speed) < _STANDING and abs(turn_rate) < _STANDING

    @property
    def _standing(self) -> bool:
        """Whether base and joints stand."""
        return (
            self._driving.base.standing
            and self._base_stands
            and bool(np.abs(self.body.velocities).max() < 10 * _STANDING)
        )

    @property
    def _at_rest(self) -> bool:
        """Whether the state would not change any more, whatever time passes."""
        base = self._driving.base
        return (
            base.standing
            and base.goal is None
            and base.heading is None
            and self._motion is None
            and not self._homeward
            and not self._looking.turning
            and self._cycles * CYCLE > self._face.until + CYCLE
            and self.body.still
            and (self._looking.done or self.running(CommandKind.LOOK_AT) is None)
        )

    # ---- arms

    def _read_gestures(self) -> None:
        """Hold the keyframes against the model."""
        body, gestures = self.body, self.description.gestures
        head = {body.pan, body.tilt}
        self._keyframes: dict[str, list[tuple[float, dict[int, float]]]] = {}
        every = {
            joint
            for name, frames in gestures.items()
            for frame in frames
            for joint in body.set_points(f"gestures.{name}", frame.joints)
        }
        for name, frames in gestures.items():
            # Going home concerns whatever another gesture may have left somewhere.
            last = dict.fromkeys(every, math.nan) if name == "home" else {}
            keyframes = []
            for frame in frames:
                points = body.set_points(f"gestures.{name}", frame.joints)
                others = last.keys() - points.keys()
                if frame.rest:
                    points |= {j: 0.0 if j in head else float(body.rest[j]) for j in others}
                elif frame.hold:
                    points |= {j: last[j] for j in others if not math.isnan(last[j])}
                last |= points
                keyframes.append((frame.t, points))
            self._keyframes[name] = keyframes
        self.gestures = tuple(gestures)

    def _plan(self, name: str) -> Motion:
        body = self.body
        free = np.full(len(body.joints), np.inf)
        head = [body.pan, body.tilt]
        low, high = body.low.copy(), body.high.copy()
        low[head], high[head] = -free[head], free[head]  # added to where the head looks
        return plan(self._keyframes[name], self._posed, self._posing, low, high, body.speeds, CYCLE)

    def _finish_gesture(self, command: Command) -> None:
        if self._motion is None:
            off = np.abs(self.body.angles - self.body.aimed)
            if off.max() < _ARRIVED:
                self.succeed(command)
