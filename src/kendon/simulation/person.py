"""A simulated person who walks up to a robot and greets (thesis Algorithm 2)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from kendon.errors import ParameterError
from kendon.features.gaze import RIM
from kendon.geometry import ORIGIN, Pose2D, Quaternion, Vec3, wrap_angle
from kendon.person import JOINTS, LateJoints, PersonFrame, pressed
from kendon.phases import Phase
from kendon.simulation.body import FACE_HEIGHT, Body, draw_body
from kendon.simulation.limbs import min_jerk
from kendon.simulation.motion import Instant, looking_along, move_now
from kendon.simulation.movements import Movement, draw_movement, shown
from kendon.simulation.scripts import Act, Script

#: A person gives up on a robot that they have not come nearer to for so long [s] ...
PATIENCE = 10.0
#: ... by so much [m]: half a pace. A robot that backs away more slowly is still reached.
_NEARER = 0.3
#: How long legs take to follow a change of speed, and heads to turn [s]; ours.
_LEGS, _TURNING = 0.2, 0.4


class SimulatedPerson:
    """A person who plays a script in front of a robot.

    The walk is Algorithm 2's: from station to station at a constant speed, the stations one
    frame apart (the thesis sets 10 a second). As the robot may move too, the goal is not fixed
    beforehand but read anew at each station: the stop distance away from the robot. A person
    who cannot catch up with a robot that runs away gives up after `PATIENCE`.

    The person has a body that moves as each act says: a movement is on its way before, so that it
    is half made when the act begins, as far as it can be told when that will be. With keys the
    head stays on the rails of Algorithm 2, pointing where each act's gaze says, and the gestures
    are given by hand as in the thesis (3.3.5). Without, the head sways, turns and dips as heads
    do, and the gestures are left to detectors.

    Args:
        script: what the person does.
        rate: frames a second.
        keys: whether the gestures are given by hand.
        seed: of chance: whose body it is, and how it waves.

    Raises:
        ParameterError: the rate is not a positive number.
    """

    def __init__(
        self, script: Script, rate: float = 30.0, *, keys: bool = True, seed: int = 0
    ) -> None:
        if not 0 < rate < math.inf:
            raise ParameterError(f"frames a second must be positive, not {rate}")
        self.script = script
        self.rate = rate
        self.keys = keys
        self.t = 0.0
        self.position = (
            script.start * math.cos(script.bearing),
            script.start * math.sin(script.bearing),
        )  # [m], in the world
        self.finished = False  # the script is over, or the person has given up
        self._frames = 0
        self._act = 0
        self._begun = [0.0]  # [s], when each act began
        self._nearest = math.inf  # [m], to which the act has brought the person
        self._came_nearer = 0.0  # [s], when
        self._rng = np.random.default_rng(seed)
        self._body = draw_body(self._rng, stature=script.height / FACE_HEIGHT)
        self._legs_speed = 0.0  # [m/s], of walking, as smooth as legs are
        self._steps = 0.0  # walked so far
        self._legs_follow = -math.expm1(-1 / (rate * _LEGS))  # of a difference, in a frame's time
        self._movements: tuple[Movement, ...] = ()
        self._half_made = 0.0  # [s], when the newest movement is
        self._plain = 0.0  # [s], when the act is plainly shown
        self._gap = math.nan  # [m] to the robot, at the last station
        first = self._draw(0)
        if first:
            self._movements = (first,)
        self._coming = self._draw(1)  # what the next act plays, if it began at 0 s

    @property
    def phase(self) -> Phase:
        """The phase the person is in.

        One that a movement shows begins when that is half made, however little time there was
        to get ready for it. Keys are pressed as the script says.
        """
        late = not self.keys and self.t < self._plain - 1 / self.rate
        return self.script.acts[self._act - late].phase

    def frame(self, robot: Pose2D = ORIGIN, face: Vec3 = (0.0, 0.0, 1.2)) -> PersonFrame:
        """The person now, seen from a robot.

        Args:
            robot: the robot's pose in the world.
            face: the robot's face in its base frame [m].
        """
        act = self.script.acts[self._act]
        x, y, z = robot.to_local((*self.position, self.script.height))
        if self.keys:
            # The head runs on rails, and the body hangs under it where somebody looks at it.
            head, rotation = (x, y, z), looking_along(*_look(act, (x, y, z), face))
            joints = LateJoints(JOINTS, partial(_hung, self._moving((x, y), rotation), head))
            dsal, csal, hdip = pressed(act.phase)
            return PersonFrame(
                self.t, head, rotation, joints=joints, smile=act.smile,
                dsal=dsal, csal=csal, hdip=hdip, robot=robot,
            )  # fmt: skip
        look = looking_along(*self._turning_look(self._act, (x, y, z), face))
        shown = self._moving((x, y), look)()
        return PersonFrame(
            self.t, shown.head, shown.head_rotation, joints=shown.joints, smile=act.smile,
            robot=robot,
        )  # fmt: skip

    def step(self, robot: Pose2D = ORIGIN) -> None:
        """Go on to the next station: walk, end acts, one frame's time later."""
        act = self.script.acts[self._act]
        self._frames += 1
        self.t = self._frames / self.rate
        before = self.position
        if act.walking:
            self._walk(robot)
        self._swing(math.dist(before, self.position) * self.rate)
        distance = self._distance(robot)
        self._get_ready(distance)
        arrived = distance <= self.script.stop_distance + 1e-6
        over = self.t - self._begun[-1] >= act.seconds - 1e-9  # False for acts without a time
        there = distance <= act.until_distance + 1e-6 or arrived
        if over or (math.isfinite(act.until_distance) and there):
            self._begin(self._act + 1)
        elif math.isfinite(act.until_distance):
            self._lose_patience(distance)

    def _begin(self, act: int) -> None:
        if act == len(self.script.acts):
            self.finished = True
        else:
            self._act = act
            self._begun.append(self.t)
            self._nearest, self._came_nearer = math.inf, self.t
            self._begin_movement()
            self._plain = self._half_made if self.script.acts[act].plays else self.t
            self._coming = self._draw(act + 1)

    def _draw(self, act: int) -> Movement | None:
        """The movement of an act, as if that began at 0 s."""
        if act >= len(self.script.acts) or not (kind := self.script.acts[act].plays):
            return None
        near = self.script.acts[act].phase is Phase.CS
        drawn = draw_movement(kind, self._rng, handed=self._body.handed, near=near)
        return shown(drawn, 0.0, self.script.acts[act].seconds)

    def _get_ready(self, distance: float) -> None:
        """Begin the next act's movement when what it takes to be seen is all the time left."""
        act = self.script.acts[self._act]
        nearing, self._gap = (self._gap - distance) * self.rate, distance
        if self._coming and self._coming.begin < 0:
            if math.isfinite(act.seconds):
                left = act.seconds - (self.t - self._begun[-1])
            else:
                way = distance - max(act.until_distance, self.script.stop_distance)
                left = way / nearing if nearing > 0 else math.inf
            if left <= -self._coming.begin:
                self._begin_movement()

    def _begin_movement(self) -> None:
        """Begin what is coming; a movement that is not over goes on beside it."""
        self._movements = tuple(m for m in self._movements if m.end > self.t)
        if self._coming:
            self._movements += (replace(self._coming, begin=self.t),)
            self._half_made = self.t - self._coming.begin
            self._coming = None

    def _swing(self, speed: float) -> None:
        """Let the legs follow the person's speed."""
        self._legs_speed += (speed - self._legs_speed) * self._legs_follow
        self._steps += self._body.steps_per_second(self._legs_speed) / self.rate

    def _moving(self, place: tuple[float, float], look: Quaternion) -> Callable[[], Instant]:
        """How the body is now, seen at a place by a robot that it faces [m]; to be worked out."""
        return partial(
            _facing, self._body, self.t, place, look, self._legs_speed, self._steps,
            self._movements,
        )  # fmt: skip

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

    def _turning_look(self, act: int, head: Vec3, face: Vec3) -> tuple[float, float]:
        """From the last act's look to this one's in the time heads take to turn."""
        there = _look(self._looking(act), head, face)
        since = (self.t - self._begun[act]) / _TURNING
        if act == 0 or since >= 1:
            return there
        here = self._turning_look(act - 1, head, face)
        share = min_jerk(since)
        yaw = here[0] + share * wrap_angle(there[0] - here[0])
        return yaw, here[1] + share * (there[1] - here[1])

    def _looking(self, act: int) -> Act:
        """The act whose look the head has; one that dips its head leaves the look to the last."""
        while act > 0 and self.script.acts[act].plays == "dip":
            act -= 1
        return self.script.acts[act]


def _facing(
    body: Body, t: float, place: tuple[float, float], look: Quaternion, speed: float, steps: float,
    movements: tuple[Movement, ...],
) -> Instant:  # fmt: skip
    """A body whose face is at a place and that faces the origin [m]; the rest as in `move_now`."""
    x, y = place
    heading, way = math.atan2(-y, -x), math.hypot(x, y)
    # The pelvis is behind the face.
    behind = 1 + body.face[0] / way if way > 0 else 1.0
    return move_now(body, t, behind * x, behind * y, heading, look, speed, steps, movements)


def _hung(moving: Callable[[], Instant], head: Vec3) -> dict[str, Vec3]:
    """The joints of a body, hung under a given head [m]."""
    shown = moving()
    dx, dy, dz = (there - here for there, here in zip(head, shown.head, strict=True))
    return {n: (x + dx, y + dy, z + dz) for n, (x, y, z) in shown.joints.items()}


def _look(act: Act, head: Vec3, face: Vec3) -> tuple[float, float]:
    """Yaw and pitch so that the gaze ray meets the robot's frontal plane where it should.

    A point s beside the face (or below it) has the gaze feature g if s = k |point - head|
    with k = g tan 30 degrees (3.7-3.8), a quadratic equation in s.

    Args:
        act: says how far beside the face, and whether to the side or below.
        head: the person's face in the robot's base frame [m].
        face: the robot's.
    """
    # At k = 1 the ray runs along the plane and never meets it.
    k = min(act.gaze * RIM, 0.999)
    dx, dy, dz = face[0] - head[0], face[1] - head[1], face[2] - head[2]
    b = -k * (dz if act.looks_down else dy)
    beside = k * (b + math.sqrt(b * b + (1 - k * k) * (dx * dx + dy * dy + dz * dz))) / (1 - k * k)
    if act.looks_down:
        dz -= beside
    else:
        dy -= beside
    return math.atan2(dy, dx), math.atan2(-dz, math.hypot(dx, dy))
