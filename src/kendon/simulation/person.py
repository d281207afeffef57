"""A simulated person who walks up to a robot and greets (thesis Algorithm 2)."""

from __future__ import annotations

import math

from kendon.errors import ParameterError
from kendon.features.gaze import CONE_ANGLE
from kendon.geometry import ORIGIN, Pose2D, Quaternion, Vec3, compose, yaw_quaternion
from kendon.person import PersonFrame
from kendon.phases import Phase
from kendon.simulation.scripts import Script

#: A person gives up on a robot that they have not come nearer to for so long [s] ...
PATIENCE = 10.0
#: ... by so much [m]: half a pace. A robot that backs away more slowly is still reached.
_NEARER = 0.3


class SimulatedPerson:
    """A person who plays a script in front of a robot.

    The walk is Algorithm 2's: from station to station at a constant speed, the stations one
    frame apart (the thesis sets 10 a second). As the robot may move too, the goal is not fixed
    beforehand but read anew at each station: the stop distance away from the robot. A person
    who cannot catch up with a robot that runs away gives up after `PATIENCE`.

    Args:
        script: what the person does.
        rate: frames a second.

    Raises:
        ParameterError: the rate is not a positive number.
    """

    def __init__(self, script: Script, rate: float = 30.0) -> None:
        if not 0 < rate < math.inf:
            raise ParameterError(f"frames a second must be positive, not {rate}")
        self.script = script
        self.rate = rate
        self.t = 0.0
        self.position = (
            script.start * math.cos(script.bearing),
            script.start * math.sin(script.bearing),
        )  # [m], in the world
        self.finished = False  # the script is over, or the person has given up
        self._frames = 0
        self._act = 0
        self._act_began = 0.0
        self._nearest = math.inf  # [m], to which the act has brought the person
        self._came_nearer = 0.0  # [s], when

    @property
    def phase(self) -> Phase:
        """The phase the person is in."""
        return self.script.acts[self._act].phase

    def frame(self, robot: Pose2D = ORIGIN, face: Vec3 = (0.0, 0.0, 1.2)) -> PersonFrame:
        """The person now, seen from a robot.

        Args:
            robot: the robot's pose in the world.
            face: the robot's face in its base frame [m].
        """
        act = self.script.acts[self._act]
        head = (*self.position, self.script.height)
        in_world = PersonFrame(
            self.t,
            head,
            self._head_rotation(head, robot, face),
            smile=act.smile,
            dsal=float(act.phase is Phase.DS),
            csal=float(act.phase is Phase.CS),
            hdip=float(act.phase is Phase.HD),
        )
        return in_world.seen_from(robot)

    def step(self, robot: Pose2D = ORIGIN) -> None:
        """Go on to the next station: walk, end acts, one frame's time later."""
        act = self.script.acts[self._act]
        self._frames += 1
        self.t = self._frames / self.rate
        if act.walking:
            self._walk(robot)
        distance = self._distance(robot)
        arrived = distance <= self.script.stop_distance + 1e-6
        over = self.t - self._act_began >= act.seconds - 1e-9  # False for acts without a time
        there = distance <= act.until_distance + 1e-6 or arrived
        if over or (math.isfinite(act.until_distance) and there):
            self._begin(self._act + 1)
        elif math.isfinite(act.until_distance):
            self._lose_patience(distance)

    def _begin(self, act: int) -> None:
        if act == len(self.script.acts):
            self.finished = True
        else:
            self._act, self._act_began = act, self.t
            self._nearest, self._came_nearer = math.inf, self.t

    def _lose_patience(self, distance: float) -> None:
        if distance <= self._nearest - _NEARER:
            self._nearest, self._came_nearer = distance, self.t
        elif self.t - self._came_nearer >= PATIENCE:
            self.finished = True

    def _walk(self, robot: Pose2D) -> None:
        way = self._distance(robot) - self.script.stop_distance
        if way <= 0:
            return
        x, y = self.position
        toward = math.atan2(robot.y - y, robot.x - x)
        length = min(self.script.speed / self.rate, way)
        self.position = (x + length * math.cos(toward), y + length * math.sin(toward))

    def _distance(self, robot: Pose2D) -> float:
        return math.hypot(self.position[0] - robot.x, self.position[1] - robot.y)

    def _head_rotation(self, head: Vec3, robot: Pose2D, face: Vec3) -> Quaternion:
        """Turned so that the gaze ray meets the robot's frontal plane where the act's gaze is.

        A point s beside the face (or below it) has the gaze feature g if s = k |point - head|
        with k = g tan 30 degrees (3.7-3.8), a quadratic equation in s.
        """
        act = self.script.acts[self._act]
        # At k = 1 the ray runs along the plane and never meets it.
        k = min(act.gaze * math.tan(CONE_ANGLE / 2), 0.999)
        to_face = [there - here for there, here in zip(face, robot.to_local(head), strict=True)]
        axis, side = (2, -1.0) if act.looks_down else (1, -1.0)
        b = k * side * to_face[axis]
        way = math.hypot(*to_face)
        beside = k * (b + math.sqrt(b * b + (1 - k * k) * way * way)) / (1 - k * k)
        to_face[axis] += side * beside
        dx, dy, dz = to_face
        yaw = math.atan2(dy, dx) + robot.yaw
        pitch = math.atan2(-dz, math.hypot(dx, dy))
        return compose(yaw_quaternion(yaw), (0.0, math.sin(pitch / 2), 0.0, math.cos(pitch / 2)))
