"""A simulated person who does as told, with the inertia of a body.

Algorithm 2 of the thesis moves a person from station to station at a constant speed. Here the
stations are as close, but people set off and stop as people do, turn, and look where they are
told.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from kendon.errors import ParameterError
from kendon.geometry import Pose2D, wrap_angle
from kendon.person import PersonFrame
from kendon.phases import Phase
from kendon.simulation.body import FACE_HEIGHT, Body, draw_body
from kendon.simulation.deeds import Deed, Gesture, Look, Smile, Stand, Turn, WalkTo
from kendon.simulation.motion import looking_along, move_now
from kendon.simulation.movements import Movement, draw_movement

#: Setting off takes one step, some 0.5 s (Breniere & Do 1986), and stopping as long [m/s^2].
ACCELERATION = 2.4
#: Bodies turn by a quarter in about a second, heads faster (ours) [rad/s].
TURN_RATE, HEAD_RATE = 2.5, 5.0
#: How long limbs, heads and smiles take to follow [s]; ours.
_LEGS, _HEAD, _FACE = 0.2, 0.12, 0.2
#: How far heads turn from the body's heading, and look up or down [rad].
_MOST_TURNED, _MOST_PITCHED = math.radians(75), math.radians(55)
#: A head this near to where it was to turn is there [rad].
_THERE = math.radians(8)
#: Who walks more slowly than this stands [m/s].
STILL = 0.1
#: Within this of the robot a salutation is a close one, within that an approach the final one
#: (thesis 2.1.5, 2.1.6) [m].
NEAR, FINAL = 1.8, 3.0
#: Whose way misses the robot's middle by less than this comes to it [m]; who looks within that of
#: it looks at it [rad], the gaze cone of thesis 3.3.3.
_MISSES, _LOOKS = 0.7, math.radians(30)


class Actor:
    """A person who obeys `act`, frame by frame.

    Args:
        start: where the person stands, and where the body points.
        body: whose; drawn if left out.
        speed: the usual walking speed [m/s].
        rate: frames a second.
        seed: of chance: the body, and how it moves.

    Raises:
        ParameterError: the speed or the rate is not a positive number.
    """

    def __init__(
        self, start: Pose2D, *, body: Body | None = None, speed: float = 1.2,
        rate: float = 30.0, seed: int = 0,
    ) -> None:  # fmt: skip
        for name, value in (("the speed", speed), ("the number of frames a second", rate)):
            if not 0 < value < math.inf:
                raise ParameterError(f"{name} of a person must be positive, not {value}")
        self._rng = np.random.default_rng(seed)
        self.body = body or draw_body(self._rng)
        self.rate = rate
        self.speed = speed
        self.t = 0.0
        self.x, self.y, self.heading = start
        self.velocity = (0.0, 0.0)  # [m/s]
        self.smiling = 1.0  # [0-5], as far as the face has followed
        self.movements: list[Movement] = []  # those that are not over, and the last ones
        self._frames = 0
        self._goal: WalkTo | None = None
        self._turn: float | None = None  # [rad], the heading to turn to
        self._look = Look()
        self._smile = 1.0
        self._yaw, self._pitch = start.yaw, 0.0  # [rad], of the head
        self._legs = 0.0  # [m/s], the speed that the legs walk at
        self._steps = 0.0
        self._wander = self._rng.uniform(0, 2 * math.pi, 2).tolist()  # [rad]; heads are never still
        # The share of a difference that each makes up for in a frame's time, exponentially.
        self._legs_follow, self._head_follows, self._face_follows = (
            -math.expm1(-1 / (rate * seconds)) for seconds in (_LEGS, _HEAD, _FACE)
        )

    @property
    def place(self) -> tuple[float, float]:
        """Under the face of the person when upright [m], world."""
        return self.x, self.y

    @property
    def height(self) -> float:
        """Of the face when upright [m]."""
        return FACE_HEIGHT * self.body.stature

    @property
    def walking_at(self) -> float:
        """How fast the person walks [m/s]."""
        return math.hypot(*self.velocity)

    @property
    def arrived(self) -> bool:
        """Whether there is nowhere left to walk to."""
        return self._goal is None

    @property
    def looks_there(self) -> bool:
        """Whether the head has come to where the person wants to look, but for its wandering."""
        yaw, pitch = self._looking()
        off = 0.0 if yaw is None else wrap_angle(yaw - self._yaw)
        return abs(off) < _THERE and abs(pitch - self._pitch) < _THERE

    def showing(self, gesture: str) -> bool:
        """Whether a gesture is plainly shown: from half into the movement to half out of it."""
        return any(
            m.gesture == gesture and m.begin + m.rise / 2 <= self.t < m.end - m.fall / 2
            for m in self.movements
        )

    def phase(self, robot: Pose2D) -> Phase | None:
        """What the person is doing to a robot, by what is to be seen of it; None = not greeting.

        Salutations are what is shown, near or far; otherwise whoever walks up to the robot
        approaches, and whoever stands and looks at it initiates an approach.
        """
        away = math.hypot(self.x - robot.x, self.y - robot.y)
        if self.showing("csal") or (self.showing("dsal") and away < NEAR):
            return Phase.CS
        if self.showing("dsal"):
            return Phase.DS
        if self.showing("hdip"):
            return Phase.HD
        to_robot = math.atan2(robot.y - self.y, robot.x - self.x)
        if self.walking_at > STILL:
            course = math.atan2(self.velocity[1], self.velocity[0])
            off = abs(wrap_angle(course - to_robot))
            if off < math.pi / 2 and away * math.sin(off) < _MISSES:
                return Phase.FA if away < FINAL else Phase.APP
            return None
        return Phase.IA if abs(wrap_angle(self._yaw - to_robot)) < _LOOKS else None

    def act(self, deed: Deed) -> Movement | None:
        """Begin to do something; what else is being done goes on unless it cannot.

        Returns:
            The movement of a gesture.
        """
        match deed:
            case WalkTo():
                self._goal, self._turn = deed, None
            case Stand():
                self._goal = None
            case Turn():
                self._turn = deed.yaw
            case Look():
                self._look = deed
            case Smile():
                self._smile = deed.level
            case Gesture():
                drawn = deed.movement or draw_movement(
                    deed.kind, self._rng, handed=self.body.handed
                )
                self._lower(drawn)
                self.movements.append(replace(drawn, begin=self.t))
                return self.movements[-1]
        return None

    def change(self, old: Movement, new: Movement) -> Movement:
        """Go on with a movement in another way: a hand that was taken is shaken now."""
        self.movements[self.movements.index(old)] = new
        return new

    def lower(self, movement: Movement) -> Movement:
        """End a movement early."""
        duration = max(self.t - movement.begin, movement.rise) + movement.fall
        if duration >= movement.duration:
            return movement
        return self.change(movement, replace(movement, duration=duration))

    def _lower(self, other: Movement) -> None:
        """A hand does one thing at a time."""
        for m in list(self.movements):
            if m.end > self.t and set(m.hands) & set(other.hands):
                self.lower(m)

    def frames(self, count: int) -> list[PersonFrame]:
        """Live on for so many frames, and return them, in the world."""
        frames = [self._step() for _ in range(count)]
        self.movements = [m for m in self.movements if m.end > self.t - 1.0]
        return frames

    def _step(self) -> PersonFrame:
        """One frame's time of walking, turning and looking; the person after it."""
        self._frames += 1
        self.t = self._frames / self.rate
        dt = 1 / self.rate
        self._walk(dt)
        self._turn_body(dt)
        self._turn_head(dt)
        self.smiling += (self._smile - self.smiling) * self._face_follows
        self._legs += (self.walking_at - self._legs) * self._legs_follow
        self._steps += self.body.steps_per_second(self._legs) * dt
        return self.frame()

    def frame(self) -> PersonFrame:
        """The person now, in the world."""
        ahead = self.body.face[0]
        shown = move_now(
            self.body, self.t, self.x - ahead * math.cos(self.heading),
            self.y - ahead * math.sin(self.heading), self.heading,
            looking_along(self._yaw, self._pitch), self._legs, self._steps, self.movements,
        )  # fmt: skip
        return PersonFrame(
            self.t, shown.head, shown.head_rotation, joints=shown.joints, smile=self.smiling
        )

    def _walk(self, dt: float) -> None:
        """Toward the goal, no faster than one can still stop there."""
        wanted = (0.0, 0.0)
        goal = self._goal
        if goal is not None:
            dx, dy = goal.x - self.x, goal.y - self.y
            way = math.hypot(dx, dy)
            usual = goal.speed if goal.speed == goal.speed else self.speed
            # What can still be braked away, frame by frame, within the way that is left.
            loss = ACCELERATION * dt / 2
            top = min(usual, math.sqrt(loss * loss + 2 * ACCELERATION * way) - loss, way / dt)
            if way < 0.01 and self.walking_at < STILL:
                self._goal = None
            elif way > 0:
                wanted = (dx / way * top, dy / way * top)
        ax, ay = wanted[0] - self.velocity[0], wanted[1] - self.velocity[1]
        needed, most = math.hypot(ax, ay), ACCELERATION * dt
        share = min(1.0, most / needed) if needed > 0 else 0.0
        self.velocity = (self.velocity[0] + share * ax, self.velocity[1] + share * ay)
        self.x += self.velocity[0] * dt
        self.y += self.velocity[1] * dt

    def _turn_body(self, dt: float) -> None:
        wanted = self._turn
        goal = self._goal
        if goal is not None and not goal.backward and self.walking_at > STILL:
            wanted = math.atan2(self.velocity[1], self.velocity[0])
        elif wanted is None and (ahead := self._looking()[0]) is not None:
            off = wrap_angle(ahead - self.heading)
            if abs(off) > _MOST_TURNED:  # necks turn so far; then bodies do
                wanted = ahead
        if wanted is None:
            return
        off, most = wrap_angle(wanted - self.heading), TURN_RATE * dt
        self.heading = wrap_angle(self.heading + min(max(off, -most), most))
        if abs(off) <= most:
            self._turn = None

    def _looking(self) -> tuple[float | None, float]:
        """Yaw and pitch [rad] of where the person wants to look."""
        if self._look.at is None:
            return None, self._look.down
        x, y, z = self._look.at
        dx, dy = x - self.x, y - self.y
        yaw = math.atan2(dy, dx) + self._look.aside
        return yaw, math.atan2(self.height - z, math.hypot(dx, dy)) + self._look.down

    def _turn_head(self, dt: float) -> None:
        yaw, pitch = self._looking()
        off = self._look.aside if yaw is None else wrap_angle(yaw - self.heading)
        yaw = self.heading + min(max(off, -_MOST_TURNED), _MOST_TURNED)
        # People seldom keep their noses exactly on what they look at.
        a, b = self._wander
        yaw += 0.05 * math.sin(2.9 * self.t + a) + 0.04 * math.sin(5.3 * self.t + b)
        pitch += 0.04 * math.sin(3.7 * self.t + b)
        follow, most = self._head_follows, HEAD_RATE * dt
        turn = wrap_angle(yaw - self._yaw) * follow
        self._yaw = wrap_angle(self._yaw + min(max(turn, -most), most))
        nod = (min(max(pitch, -_MOST_PITCHED), _MOST_PITCHED) - self._pitch) * follow
        self._pitch += min(max(nod, -most), most)
