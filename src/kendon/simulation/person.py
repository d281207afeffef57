"""A simulated person who walks up to a robot and greets (thesis Algorithm 2)."""

from __future__ import annotations

import math

from kendon.features.gaze import CONE_ANGLE
from kendon.geometry import ORIGIN, Pose2D, Quaternion, Vec3, compose, yaw_quaternion
from kendon.person import PersonFrame
from kendon.phases import Phase
from kendon.simulation.scripts import Script


class SimulatedPerson:
    """A person who plays a script in front of a robot.

    The walk is Algorithm 2's: from station to station at a constant speed, the stations one
    frame apart (the thesis sets 10 a second). As the robot may move too, the goal is not fixed
    beforehand but read anew at each station: the stop distance away from the robot.

    Args:
        script: what the person does.
        rate: frames a second.
    """

    def __init__(self, script: Script, rate: float = 30.0) -> None:
        self.script = script
        self.rate = rate
        self.t = 0.0
        self.position = (
            script.start * math.cos(script.bearing),
            script.start * math.sin(script.bearing),
        )  # [m], in the world
        self.finished = False
        self._frames = 0
        self._act = 0
        self._act_began = 0.0

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
            self._head_rotation(head, robot.to_world(face)),
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
        arrived = self._distance(robot) <= self.script.stop_distance + 1e-6
        over = self.t - self._act_began >= act.seconds - 1e-9  # False for acts without a time
        there = self._distance(robot) <= act.until_distance + 1e-6 or arrived
        if over or (math.isfinite(act.until_distance) and there):
            self._begin(self._act + 1)

    def _begin(self, act: int) -> None:
        if act == len(self.script.acts):
            self.finished = True
        else:
            self._act, self._act_began = act, self.t

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

    def _head_rotation(self, head: Vec3, target: Vec3) -> Quaternion:
        """Turned from the robot's face by the angle that gives the act's gaze (3.8).

        For a ray that leaves the line to the face by the angle a, the distance beside the face
        over the way to the plane is sin a.
        """
        act = self.script.acts[self._act]
        away = math.asin(min(1.0, act.gaze * math.tan(CONE_ANGLE / 2)))
        dx, dy, dz = (target[i] - head[i] for i in range(3))
        yaw = math.atan2(dy, dx)
        pitch = math.atan2(-dz, math.hypot(dx, dy))
        if act.looks_down:
            pitch += away
        else:
            yaw += away
        return compose(yaw_quaternion(yaw), (0.0, math.sin(pitch / 2), 0.0, math.cos(pitch / 2)))
