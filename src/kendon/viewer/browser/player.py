"""A person whom the user moves: they walk where they are told and greet when they are told.

They are a simulated `Actor`, who gathers speed, brakes and turns as people do; here is only what
the user's wishes mean before a robot that is in the way or moves.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from kendon.errors import ParameterError, UnknownNameError
from kendon.geometry import ORIGIN, Pose2D, Vec3
from kendon.person import GESTURES, PersonFrame
from kendon.simulation import Movement, draw_body, draw_movement
from kendon.simulation.actor import ACCELERATION, Actor
from kendon.simulation.deeds import Gesture, Look, Smile, Turn, WalkTo
from kendon.simulation.movements import lasting
from kendon.simulation.scripts import WALKING_SPEED

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
#: Who looks away or down turns the head by so much [rad].
_ASIDE, _DOWN = math.radians(65), math.radians(40)
#: A step shorter than this is taken without turning to it [m], and one this short not at all.
_SHUFFLE, _THERE = 0.7, 0.01
#: How much they smile when they do, and when they do not [0-5].
_SMILING, _SERIOUS = 3.5, 1.0


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
        self.goal = place  # [m], where they are going
        self._distance = math.nan  # [m] from the robot, when that is where they are going
        self.looking = "robot"
        self.smiling = False
        self.facing = "robot"  # or "away": where they turn when they stand
        self._rng = np.random.default_rng(seed)
        x, y = place
        self.actor = Actor(
            Pose2D(x, y, math.atan2(-y, -x)), body=draw_body(self._rng, stature=1.72),
            speed=WALKING_SPEED, rate=rate, seed=seed,
        )  # fmt: skip
        self._shown = self.actor.frame()

    # ---- what the user asks for

    def walk_to(self, x: float, y: float) -> None:
        """Walk somewhere; as near as `NEAREST` if it lies at the robot.

        Raises:
            ParameterError: the place is not on the floor.
        """
        if not (math.isfinite(x) and math.isfinite(y)):
            raise ParameterError(f"a place to walk to needs finite numbers, not ({x}, {y})")
        away = max(1.0, math.hypot(x, y) / FARTHEST)
        self.goal = x / away, y / away
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
        (x, y), (vx, vy) = self.actor.place, self.actor.velocity
        braking = self.actor.walking_at / (2 * ACCELERATION)  # [s], at the present speed
        self.goal = x + braking * vx, y + braking * vy

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
        self.actor.act(Smile(_SMILING if on else _SERIOUS))

    def act(self, name: str, robot: Pose2D = ORIGIN) -> None:
        """Perform a gesture; shown near the robot, a salutation is a close one.

        Raises:
            UnknownNameError: there is no such gesture.
        """
        if name not in ACTS:
            raise UnknownNameError("gesture", name, ACTS)
        near = math.dist(self.actor.place, robot[:2]) < _NEAR
        drawn = draw_movement(name, self._rng, handed=self.actor.body.handed, near=near)
        if name == "handshake":
            drawn = replace(drawn, wait=0.0)
        if not drawn.hands:  # a head does one thing at a time, as hands do
            for movement in self._going_on():
                if not movement.hands:
                    self.actor.lower(movement)
        self.actor.act(Gesture(name, lasting(drawn, ACTS[name])))

    @property
    def doing(self) -> str:
        """The gestures that are going on, in words."""
        return ", ".join(movement.kind for movement in self._going_on())

    def _going_on(self) -> list[Movement]:
        return [m for m in self.actor.movements if m.end > self.actor.t]

    # ---- time

    def step(self, robot: Pose2D = ORIGIN, face: Vec3 = (0.0, 0.0, 1.2)) -> None:
        """Let one frame's time pass.

        Args:
            robot: the robot's pose in the world.
            face: the robot's face in its base frame [m].
        """
        self._walk(robot)
        self._look(robot.to_world(face))
        [self._shown] = self.actor.frames(1)

    def _walk(self, robot: Pose2D) -> None:
        if not math.isnan(self._distance):
            self.goal = self._before(robot, self._distance)
        goal = self.goal
        if math.dist(goal, robot[:2]) < NEAREST:  # on the side they come from
            goal = self._before(robot, NEAREST)
        x, y = self.actor.place
        left = math.dist(goal, (x, y))
        if left > _THERE:
            course = self._past(goal, robot)
            there = x + left * math.cos(course), y + left * math.sin(course)
            self.actor.act(WalkTo(*there, backward=left <= _SHUFFLE))
        if left <= _SHUFFLE:
            away = math.pi if self.facing == "away" else 0.0
            self.actor.act(Turn(math.atan2(robot.y - y, robot.x - x) + away))

    def _before(self, robot: Pose2D, distance: float) -> tuple[float, float]:
        """The place at a distance from the robot, on the side where they are [m]."""
        x, y = self.actor.place
        side = math.atan2(y - robot.y, x - robot.x)
        return robot.x + distance * math.cos(side), robot.y + distance * math.sin(side)

    def _past(self, goal: tuple[float, float], robot: Pose2D) -> float:
        """Where to walk [rad]: straight to the goal, or past a robot in between."""
        x, y = self.actor.place
        straight = math.atan2(goal[1] - y, goal[0] - x)
        to_robot = math.atan2(robot.y - y, robot.x - x)
        distance = math.hypot(robot.x - x, robot.y - y)
        along = distance * math.cos(to_robot - straight)
        beside = distance * math.sin(to_robot - straight)  # positive: left
        if not 0 < along < math.dist(goal, (x, y)) or abs(beside) >= NEAREST:
            return straight
        # Along the tangent of a circle around the robot, or along the circle once there.
        edge = NEAREST + _BERTH
        off = math.asin(min(1.0, edge / distance)) + max(0.0, 1 - distance / edge)
        return to_robot - math.copysign(off, beside)

    def _look(self, face: Vec3) -> None:
        x, y, _ = face
        level = (x, y, self.actor.height)
        looks = {"robot": Look(face), "away": Look(level, _ASIDE), "down": Look(level, 0.0, _DOWN)}
        self.actor.act(looks[self.looking])

    def frame(self, robot: Pose2D = ORIGIN) -> PersonFrame:
        """The person now, seen from a robot that stands at `robot` in the world."""
        shown = self._shown
        if self.keys:
            gestures = {movement.gesture for movement in self._going_on()}
            dsal, csal, hdip = (float(name in gestures) for name in GESTURES)
            shown = shown._replace(dsal=dsal, csal=csal, hdip=hdip)
        return shown.seen_from(robot)
