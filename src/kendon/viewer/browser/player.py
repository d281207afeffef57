"""A person whom the user moves: they walk where they are told and greet when they are told.

What they do is what a simulated person's body does (`kendon.simulation`): they gather speed and
brake as people do, turn to where they walk and then to the robot, and their heads turn in time.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from kendon.errors import ParameterError, UnknownNameError
from kendon.geometry import ORIGIN, Pose2D, Vec3, wrap_angle, yaw_quaternion
from kendon.geometry import compose as turned_by
from kendon.person import GESTURES, FloatArray, PersonFrame
from kendon.simulation import Movement, draw_body, draw_movement, move
from kendon.simulation.body import FACE_HEIGHT
from kendon.simulation.movements import lasting

#: A medium-to-slow walk (thesis 3.4) [m/s], and how fast people set off and stop [m/s^2].
WALKING_SPEED, ACCELERATION = 1.2, 1.5
#: What the user can have them do, and for about how long [s].
ACTS: dict[str, float] = {
    "wave": 2.0, "toss": 0.8, "nod": 1.2, "dip": 0.7, "bow": 1.6, "handshake": 4.0, "hug": 3.0,
}  # fmt: skip
#: Where they can look.
LOOKS = ("robot", "away", "down")
#: How near to a robot they walk [m]: an arm's length, for a handshake.
NEAREST = 0.8
#: How much room they leave who walk past it, beyond that [m].
_BERTH = 0.15
#: The floor they can be sent about [m].
FARTHEST = 12.0
#: Nearer than this a salutation is a close one (thesis 3.4) [m].
_NEAR = 1.6
#: How fast bodies and heads turn [rad/s], how soon they get there [1/s], how far heads turn.
_TURN, _HEAD_TURN, _SOON, _MOST = 2.5, 4.0, 6.0, math.radians(75)
#: A step shorter than this is taken without turning to it [m].
_SHUFFLE = 0.7
#: How soon a smile comes and goes [s].
_SMILE = 0.3


class Player:
    """A person under a user's control, in front of a robot.

    Args:
        place: where they stand at first, in the world [m].
        keys: whether their gestures are given by hand, as with the thesis's keys (3.3.5), or left
            to be read off their body.
        rate: frames a second.
        seed: of chance: whose body it is.
    """

    def __init__(
        self,
        place: tuple[float, float] = (6.0, 1.5),
        *,
        keys: bool = True,
        rate: float = 30.0,
        seed: int = 1,
    ) -> None:
        self.keys = keys
        self.rate = rate
        self.t = 0.0
        self.place = np.array(place, dtype=float)  # [m], where the pelvis is
        self.velocity = np.zeros(2)  # [m/s]
        self.goal = self.place.copy()  # [m], where they are going
        self._distance = math.nan  # [m] from the robot, when that is where they are going
        self.looking = "robot"
        self.smiling = False
        self.facing = "robot"  # or "away": where they turn when they stand
        self._frames = 0
        self._rng = np.random.default_rng(seed)
        self._body = draw_body(self._rng, stature=1.72)
        self._heading = math.atan2(-self.place[1], -self.place[0])
        self._gaze = [self._heading, 0.0]  # [rad], yaw and pitch (down) of the head
        self._smile = 0.5
        self._steps = 0.0
        self._movements: list[Movement] = []

    # ---- what the user asks for

    def walk_to(self, x: float, y: float) -> None:
        """Walk somewhere; as near as `NEAREST` if it lies at the robot.

        Raises:
            ParameterError: the place is not on the floor.
        """
        if not (math.isfinite(x) and math.isfinite(y)):
            raise ParameterError(f"a place to walk to needs finite numbers, not ({x}, {y})")
        away = max(1.0, math.hypot(x, y) / FARTHEST)
        self.goal = np.array([x / away, y / away])
        self._distance = math.nan

    def walk_up(self, distance: float) -> None:
        """Walk, from where they are, to so far from the robot [m], wherever that goes.

        Raises:
            ParameterError: the distance is not a positive number.
        """
        if not 0 < distance < math.inf:
            raise ParameterError(f"a distance to walk up to is positive, not {distance}")
        self._distance = max(distance, NEAREST)

    def stop(self) -> None:
        """Stand still as soon as legs can."""
        self._distance = math.nan
        brake = float(self.velocity @ self.velocity) / (2 * ACCELERATION)
        speed = float(np.hypot(*self.velocity))
        self.goal = self.place + (self.velocity / speed * brake if speed > 1e-6 else 0.0)

    def look(self, where: str) -> None:
        """Look at the robot, away to the side, or down.

        Raises:
            UnknownNameError: there is no such direction.
        """
        if where not in LOOKS:
            raise UnknownNameError("direction to look in", where, LOOKS)
        self.looking = where

    def turn(self, facing: str) -> None:
        """Turn the body to the robot or away from it, once they stand.

        Raises:
            UnknownNameError: it is neither.
        """
        if facing not in ("robot", "away"):
            raise UnknownNameError("direction to face", facing, ("robot", "away"))
        self.facing = facing

    def smile(self, on: bool) -> None:
        """Smile, or stop smiling."""
        self.smiling = on

    def act(self, name: str, robot: Pose2D = ORIGIN) -> None:
        """Perform a gesture; shown near the robot, a salutation is a close one.

        Raises:
            UnknownNameError: there is no such gesture.
        """
        if name not in ACTS:
            raise UnknownNameError("gesture", name, ACTS)
        near = math.dist(self.place.tolist(), robot[:2]) < _NEAR
        drawn = draw_movement(name, self._rng, handed=self._body.handed, near=near)
        if name == "handshake":
            drawn = replace(drawn, wait=0.0)
        drawn = replace(lasting(drawn, ACTS[name]), begin=self.t)
        # An arm does one thing at a time, and so does a head.
        self._movements = [
            m for m in self._movements
            if not (set(m.hands) & set(drawn.hands)) and (bool(m.hands) or bool(drawn.hands))
        ]  # fmt: skip
        self._movements.append(drawn)

    @property
    def doing(self) -> str:
        """The gestures that are going on, in words."""
        return ", ".join(m.kind for m in self._movements)

    # ---- time

    def step(self, robot: Pose2D = ORIGIN, face: Vec3 = (0.0, 0.0, 1.2)) -> None:
        """Let one frame's time pass.

        Args:
            robot: the robot's pose in the world.
            face: the robot's face in its base frame [m].
        """
        dt = 1 / self.rate
        self._frames += 1
        self.t = self._frames * dt
        self._movements = [m for m in self._movements if m.end > self.t]
        self._walk(robot, dt)
        self._turn_body(robot, dt)
        self._turn_head(robot, face, dt)
        wanted = 3.5 if self.smiling else 0.5
        self._smile += (wanted - self._smile) * -math.expm1(-dt / _SMILE)
        self._steps += self._body.steps_per_second(float(np.hypot(*self.velocity))) * dt

    def _walk(self, robot: Pose2D, dt: float) -> None:
        here = np.array(robot[:2])
        if not math.isnan(self._distance):
            side = self.place - here
            self.goal = here + side / max(1e-6, float(np.hypot(*side))) * self._distance
        goal = self.goal
        apart = goal - here
        if math.hypot(*apart) < NEAREST:  # stop short of the robot, on the side they come from
            side = self.place - here
            goal = here + side / max(1e-6, float(np.hypot(*side))) * NEAREST
        way = goal - self.place
        left = float(np.hypot(*way))
        # As fast as still lets them stop there; the last centimetres fade out.
        speed = min(WALKING_SPEED, math.sqrt(2 * 0.7 * ACCELERATION * left), 3.0 * left)
        wanted = self._past(way, here) * speed if left > 5e-3 else np.zeros(2)
        change = wanted - self.velocity
        size = float(np.hypot(*change))
        self.velocity = self.velocity + change * min(1.0, ACCELERATION * dt / max(size, 1e-9))
        self.place = self.place + self.velocity * dt

    def _past(self, way: FloatArray, robot: FloatArray) -> FloatArray:
        """The direction to walk in, a unit vector: straight, or past a robot in between."""
        left = float(np.hypot(*way))
        straight = way / left
        to_robot = robot - self.place
        distance = float(np.hypot(*to_robot))
        along = float(to_robot @ straight)
        beside = float(straight[0] * to_robot[1] - straight[1] * to_robot[0])  # positive: left
        if not 0 < along < left or abs(beside) >= NEAREST:
            return straight
        # Along the tangent of a circle around the robot, or along the circle once there.
        edge = NEAREST + _BERTH
        side = -1.0 if beside > 0 else 1.0
        off = math.asin(min(1.0, edge / distance)) + max(0.0, 1 - distance / edge)
        course = math.atan2(to_robot[1], to_robot[0]) + side * off
        return np.array([math.cos(course), math.sin(course)])

    def _turn_body(self, robot: Pose2D, dt: float) -> None:
        speed = float(np.hypot(*self.velocity))
        far = float(np.hypot(*(self.goal - self.place))) > _SHUFFLE
        if speed > 0.25 and far:
            wanted = math.atan2(self.velocity[1], self.velocity[0])
        else:
            wanted = self._toward(robot) + (math.pi if self.facing == "away" else 0.0)
        error = wrap_angle(wanted - self._heading)
        rate = min(max(_SOON * error, -_TURN), _TURN)
        self._heading = wrap_angle(self._heading + rate * dt)

    def _turn_head(self, robot: Pose2D, face: Vec3, dt: float) -> None:
        x, y, z = robot.to_world(face)
        ahead, side = x - self.place[0], y - self.place[1]
        down = FACE_HEIGHT * self._body.stature - z
        toward = math.atan2(side, ahead)
        yaw, pitch = toward, math.atan2(down, max(0.3, math.hypot(ahead, side)))
        if self.looking == "away":
            yaw, pitch = toward + math.radians(65), 0.0
        elif self.looking == "down":
            pitch = math.radians(40)
        # Heads turn only so far on their bodies.
        aside = min(max(wrap_angle(yaw - self._heading), -_MOST), _MOST)
        wanted = (self._heading + aside, pitch)
        for axis, angle in enumerate(wanted):
            error = wrap_angle(angle - self._gaze[axis])
            rate = min(max(_SOON * error, -_HEAD_TURN), _HEAD_TURN)
            self._gaze[axis] = wrap_angle(self._gaze[axis] + rate * dt)

    def _toward(self, robot: Pose2D) -> float:
        return math.atan2(robot.y - self.place[1], robot.x - self.place[0])

    def frame(self, robot: Pose2D = ORIGIN) -> PersonFrame:
        """The person now, seen from a robot that stands at `robot` in the world."""
        yaw, pitch = self._gaze
        look = turned_by(yaw_quaternion(yaw), (0.0, math.sin(pitch / 2), 0.0, math.cos(pitch / 2)))
        motion = move(
            self._body,
            np.array([self.t]),
            self.place[None],
            np.array([self._heading]),
            np.array([look]),
            np.array([float(np.hypot(*self.velocity))]),
            np.array([self._steps]),
            self._movements,
        )
        shown = {m.gesture for m in self._movements}
        given = [float(name in shown) if self.keys else math.nan for name in GESTURES]
        head, rotation = motion.head[0].tolist(), motion.head_rotation[0].tolist()
        return PersonFrame(
            self.t,
            (head[0], head[1], head[2]),
            (rotation[0], rotation[1], rotation[2], rotation[3]),
            joints={name: tuple(p[0].tolist()) for name, p in motion.joints.items()},
            smile=self._smile,
            dsal=given[0],
            csal=given[1],
            hdip=given[2],
        ).seen_from(robot)
