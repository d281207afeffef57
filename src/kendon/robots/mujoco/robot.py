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
from kendon.robots.head import HeadLimits
from kendon.robots.mujoco.body import CYCLE, Body
from kendon.robots.mujoco.description import RobotDescription, vizzy
from kendon.robots.mujoco.gaze import local_point
from kendon.robots.mujoco.motion import Chaser, Motion, plan
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
#: How quickly eyes gather speed [rad/s^2]: they reach 5 rad/s within a tenth of a second.
_EYE_ACCELERATION = 60.0


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
        self._read_head()
        self._read_expressions()
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
        return self._expression, self._level

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
            self._aim_head(point)
            self._looked = False
            sent["pan"], sent["tilt"] = self._head_target
        elif kind is CommandKind.GESTURE:
            self._motion, self._homeward = self._plan(asked["name"]), False
        elif kind is CommandKind.SAY:
            self._until[kind] = self.time + len(asked["text"].strip()) / self._speech_rate
        elif kind is CommandKind.EXPRESS:
            self._until[kind] = self.time + EXPRESSION_SECONDS
            self._show(asked["expression"], asked["intensity"])
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
            self._finish_look(command)
        elif kind is CommandKind.GESTURE:
            self._finish_gesture(command)
        elif kind is CommandKind.STOP:
            if self._standing:
                self.succeed(command)
        elif kind in self._until:
            left = self._until[kind] - self.time
            if kind is CommandKind.EXPRESS:
                share = max(0.0, left) / EXPRESSION_SECONDS
                self._level = self._levels[1] - (self._levels[1] - self._levels[0]) * share
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
        body = self.body
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
        self._look()
        targets = self._posed.copy()
        targets[body.pan] += self._pan.position
        targets[body.tilt] += self._tilt.position
        for eye, chaser in zip(body.eyes, self._eyes, strict=True):
            targets[eye] = chaser.position
        if len(self._face_joints):
            targets[self._face_joints] = self._face_at(now)
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
            and not any(chaser.rate for chaser in (self._pan, self._tilt, *self._eyes))
            and self._cycles * CYCLE > self._face_until + CYCLE
            and self.body.still
            and (self._looked or self.running(CommandKind.LOOK_AT) is None)
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

    # ---- head and eyes

    def _read_head(self) -> None:
        body, head = self.body, self.description.head
        ranges = []
        for joint, sign in ((body.pan, body.pan_sign), (body.tilt, body.tilt_sign)):
            ends = sorted((sign * float(body.low[joint]), sign * float(body.high[joint])))
            ranges.append((max(ends[0], -math.pi), min(ends[1], math.pi)))
        if head.tilt_range is not None:
            low, high = (math.radians(a) for a in head.tilt_range)
            ranges[1] = max(low, ranges[1][0]), min(high, ranges[1][1])
        rate = min(head.rate, float(body.speeds[[body.pan, body.tilt]].min()))
        self.head_limits = HeadLimits(ranges[0], ranges[1], rate)
        self._pan = Chaser(float(body.rest[body.pan]), rate, head.acceleration)
        self._tilt = Chaser(float(body.rest[body.tilt]), rate, head.acceleration)
        self._eyes = [
            Chaser(float(body.rest[eye]), float(body.speeds[eye]), _EYE_ACCELERATION)
            for eye in body.eyes
        ]
        self._eye_ranges = [(float(body.low[eye]), float(body.high[eye])) for eye in body.eyes]
        self._head_target = (0.0, 0.0)  # [rad], to the left and up
        self._reachable = True
        self._looked = False  # whether head and eyes have nothing left to do for a running look

    def _aim_head(self, point: Vec3) -> None:
        """Work out where the head must turn for a point, from where the body is now."""
        body, limits = self.body, self.head_limits
        pan, tilt = body.head.angles(body.data, point)
        pan, tilt = pan * body.pan_sign, tilt * body.tilt_sign
        sent_pan = min(max(pan, limits.pan[0]), limits.pan[1])
        sent_tilt = min(max(tilt, limits.tilt[0]), limits.tilt[1])
        self._head_target = sent_pan, sent_tilt
        self._reachable = sent_pan == pan and sent_tilt == tilt

    def _look(self) -> None:
        """Turn head and eyes on, toward the point of a running look, else to a stand."""
        body = self.body
        command = self.running(CommandKind.LOOK_AT)
        if command is None:
            for chaser in (self._pan, self._tilt, *self._eyes):
                if chaser.rate:
                    chaser.step(None, CYCLE)
            return
        point: Vec3 = command.asked["point"]
        self._aim_head(point)
        pan, tilt = self._head_target
        self._pan.step(pan * body.pan_sign, CYCLE)
        self._tilt.step(tilt * body.tilt_sign, CYCLE)
        local: dict[int, Vec3] = {}  # eyes that hang in the same body see it at the same place
        for pointer, (low, high), chaser in zip(
            body.eye_pointers, self._eye_ranges, self._eyes, strict=True
        ):
            if pointer.parent not in local:
                local[pointer.parent] = local_point(body.data, pointer.parent, point)
            chaser.step(min(max(pointer.angle(local[pointer.parent]), low), high), CYCLE)
        self._looked = not any(chaser.rate for chaser in (self._pan, self._tilt, *self._eyes))

    def _finish_look(self, command: Command) -> None:
        body, near = self.body, self.head_limits.tolerance
        self._aim_head(command.asked["point"])
        pan, tilt = self._head_target
        angles = body.angles
        there = (
            abs(angles[body.pan] - self._posed[body.pan] - pan * body.pan_sign) <= near
            and abs(angles[body.tilt] - self._posed[body.tilt] - tilt * body.tilt_sign) <= near
        )
        # A base that still turns may yet bring the point within the joints' reach.
        if there and (self._reachable or self._driving.base.standing):
            reason = "" if self._reachable else "the point lies beyond the head's joints"
            self.succeed(command, reason)

    # ---- the face

    def _read_expressions(self) -> None:
        body = self.body
        found = {
            name: body.set_points(f"expressions.{name}", joints)
            for name, joints in self.description.expressions.items()
        }
        joints = sorted({joint for points in found.values() for joint in points})
        self._face_joints = np.array(joints, dtype=np.int64)
        rest = body.rest[self._face_joints]
        self._faces = {
            name: np.array([points.get(j, body.rest[j]) for j in joints]) - rest
            for name, points in found.items()
        }
        self._face_from = self._face_to = rest
        self._face_until = -math.inf  # [s], when the face has changed
        self._expression, self._level = "neutral", 1.0
        self._levels: tuple[float, float] = (0.0, 1.0)  # the intensity before and after the change
        self.expressions = tuple(found)

    def _show(self, expression: str, intensity: float) -> None:
        same = expression == self._expression
        self._levels = (self._level if same else 0.0, intensity)
        self._expression, self._level = expression, self._levels[0]
        self._face_from = self._face_at(self.time)
        self._face_to = self.body.rest[self._face_joints] + intensity * self._faces[expression]
        self._face_until = self.time + EXPRESSION_SECONDS

    def _face_at(self, now: float) -> FloatArray:
        left = min(1.0, (self._face_until - now) / EXPRESSION_SECONDS)
        if left <= 0:
            return self._face_to
        face: FloatArray = self._face_to + (self._face_from - self._face_to) * left
        return face
