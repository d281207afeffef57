"""A unicycle base that drives to poses with limited speeds and accelerations.

Between two instants every speed ramps linearly, and the braking rule is solved for that ramp
exactly (`speed_within`). So goals are met without creeping, and how time is cut into steps
shifts only the corners of the speed profile, by less than one step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from kendon.errors import ParameterError
from kendon.geometry import Pose2D, wrap_angle
from kendon.robots.clearance import Clearance

#: The longest step of the controller [s]: 20 Hz is the rate of move_base's own controller.
STEP = 0.05
#: Off the way by more than this, the base turns on the spot before it drives [rad].
DRIVE_CONE = math.pi / 4
#: Near a goal the cone narrows with the distance, 1 rad a metre, down to this [rad]: there is
#: no way left on which to correct the course.
NARROWEST_CONE = 0.1
#: A goal at most this far behind is reached in reverse [m].
REVERSE_WITHIN = 0.5
#: Nearer to the rim than this, a standing base that may not go on counts as there [m].
RIM = 0.01


@dataclass(frozen=True, slots=True)
class BaseLimits:
    """What a base can do.

    Speed and turn rate are the defaults of base_local_planner, the planner of the move_base
    that the thesis drives Vizzy with; the accelerations are chosen: gentle next to a person
    (standing after 0.5 s and 0.25 m would be 1 m/s^2, half of it looks calm).

    Raises:
        ParameterError: a limit is not a positive, finite number.
    """

    speed: float = 0.5  # [m/s]
    acceleration: float = 0.5  # [m/s^2], also the braking
    turn_rate: float = 1.0  # [rad/s]
    turn_acceleration: float = 2.0  # [rad/s^2]

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if not (math.isfinite(value) and value > 0):
                raise ParameterError(f"a base's {f.name} is a positive, finite number, not {value}")


def speed_within(
    road: float, speed: float, acceleration: float, h: float, closing: float = 0.0
) -> float:
    """The highest speed after `h` from which braking still ends within the road.

    It solves (v + v')/2 h + v'^2/(2a) + u (h + v'/a) = s for v'.

    Args:
        road: s, the way that is left [m].
        speed: v, the present speed along it [m/s].
        acceleration: a [m/s^2].
        h: the step [s].
        closing: u, how fast the road gets shorter by itself [m/s].

    >>> round(speed_within(1.0, 1.0, 0.5, 1e-9), 6)  # v^2 / (2 a) = 1 m
    1.0
    """
    if road == math.inf:
        return math.inf
    spare = road - speed * h / 2 - closing * h
    if spare <= 0:
        return 0.0
    b = h / 2 + closing / acceleration
    return acceleration * (math.sqrt(b * b + 2 * spare / acceleration) - b)


def way_of_step(v: float, v2: float, acceleration: float, h: float) -> float:
    """The way of one step from speed `v` to `v2` [m or rad]; a stop within it is met exactly."""
    if v2 == 0 and abs(v) < acceleration * h:
        return v * abs(v) / (2 * acceleration)
    return (v + v2) / 2 * h


class UnicycleBase:
    """Pose and speeds of a base, and what it drives or turns to.

    The speeds belong to the base, not to the goal: a new goal is driven to from the speed
    the old one left.

    Args:
        start: the first pose in the world.
        limits: its speeds and accelerations.
        clearance: where it may drive.
        position_tolerance: nearer to a goal than this counts as there [m].
        yaw_tolerance: likewise for the heading [rad].
    """

    def __init__(
        self,
        start: Pose2D,
        limits: BaseLimits,
        clearance: Clearance,
        position_tolerance: float,
        yaw_tolerance: float,
    ) -> None:
        self.x, self.y, self.yaw = start.x, start.y, wrap_angle(start.yaw)
        self.speed = 0.0  # [m/s], forward
        self.turn_rate = 0.0  # [rad/s], to the left
        self.limits = limits
        self.clearance = clearance
        self.position_tolerance = position_tolerance
        self.yaw_tolerance = yaw_tolerance
        self.goal: Pose2D | None = None  # drive there
        self.heading: float | None = None  # or turn there on the spot
        self.blocked = 0.0  # [s], for how long it has stood because the way is not free
        self._reverse = False

    @property
    def standing(self) -> bool:
        """Whether it neither drives nor turns."""
        return self.speed == 0.0 and self.turn_rate == 0.0

    @property
    def off_goal(self) -> float:
        """From here to the goal's position [m]; 0 without a goal."""
        return 0.0 if self.goal is None else math.hypot(self.goal.x - self.x, self.goal.y - self.y)

    @property
    def arrived(self) -> bool:
        """Whether it stands at its goal or heading, or as near as the person lets it."""
        if self.speed != 0 or self.turn_rate != 0:
            return False
        yaw = self.heading if self.goal is None else self.goal.yaw
        if yaw is None:
            return False
        if abs(wrap_angle(yaw - self.yaw)) > self.yaw_tolerance:
            return False
        return self.off_goal <= self.position_tolerance or self._at_rim()

    def aim(self, *, goal: Pose2D | None = None, heading: float | None = None) -> None:
        """Set what to drive or turn to; with neither the base brakes and stands."""
        self.goal, self.heading, self.blocked = goal, heading, 0.0

    def advance(self, dt: float) -> None:
        """Drive on for `dt` [s]."""
        if dt <= 0 or (self.standing and self.goal is None and self.heading is None):
            return
        steps = max(1, math.ceil(dt / STEP - 1e-9))
        h = dt / steps
        for done in range(1, steps + 1):
            if not self._step(h):
                # It stands and would stand on for as long as nobody moves.
                self.blocked += h * (steps - done) if self.blocked else 0.0
                return

    def _step(self, h: float) -> bool:
        """Drive on for one step; False if nothing has changed and nothing will."""
        limits = self.limits
        a, alpha = limits.acceleration, limits.turn_acceleration
        v, w = self.speed, self.turn_rate
        want_v, want_w = self._steer(h)
        w2 = min(max(want_w, w - alpha * h), w + alpha * h)
        v2 = min(max(want_v, v - a * h), v + a * h)
        if v * v2 < 0:
            v2 = 0.0  # come to a stand first, so that a step has one direction
        if v or v2:
            v2, w2 = self._guard(v2, w2, h)
        # A stop that rounding misses by a hair is a stop.
        v2 = 0.0 if abs(v2) < 1e-9 else v2
        w2 = 0.0 if abs(w2) < 1e-9 else w2
        if v or v2:
            way = way_of_step(v, v2, a, h)
            turn = way_of_step(w, w2, alpha, h)
            mid = self.yaw + turn / 2
            self.x += way * math.cos(mid)
            self.y += way * math.sin(mid)
            self.blocked = 0.0
        else:
            turn = way_of_step(w, w2, alpha, h)
            if want_v:
                self.blocked += h
        self.yaw = wrap_angle(self.yaw + turn)
        self.speed, self.turn_rate = v2, w2
        return bool(v or v2 or w or w2)

    def _steer(self, h: float) -> tuple[float, float]:
        """The speeds the goal calls for, signed: forward [m/s], left [rad/s]."""
        goal = self.goal
        if goal is None:
            return 0.0, 0.0 if self.heading is None else self._turn(self.heading - self.yaw, h)
        dx, dy = goal.x - self.x, goal.y - self.y
        rho = math.hypot(dx, dy)
        v, a = self.speed, self.limits.acceleration
        if v == 0 and (rho <= self.position_tolerance or self._at_rim()):
            return 0.0, self._turn(goal.yaw - self.yaw, h)
        if rho <= self.position_tolerance:
            # Run out on the present course: chasing the bearing of so near a point would spin.
            left = (dx * math.cos(self.yaw) + dy * math.sin(self.yaw)) * math.copysign(1.0, v)
            return math.copysign(min(abs(v), speed_within(left, abs(v), a, h)), v), 0.0
        off = wrap_angle(self.clearance.bearing(self.x, self.y, goal.x, goal.y) - self.yaw)
        # Once in reverse, stay in it a while: a goal that jitters must not flip the base.
        far, wide = (1.5, math.pi / 2) if self._reverse else (1.0, 3 * math.pi / 4)
        self._reverse = rho <= far * REVERSE_WITHIN and abs(off) > wide
        gear = 1.0
        if self._reverse:
            gear, off = -1.0, wrap_angle(off + math.pi)
        turn = self._turn(off, h)
        cone = min(DRIVE_CONE, max(NARROWEST_CONE, rho))
        if abs(off) >= cone:
            return 0.0, turn
        floor = math.cos(cone)
        top = self.limits.speed * (math.cos(off) - floor) / (1 - floor)
        return gear * min(top, speed_within(rho * math.cos(off), gear * v, a, h)), turn

    def _turn(self, error: float, h: float) -> float:
        """The turn rate that takes a heading error to zero and stops there [rad/s]."""
        error, w, limits = wrap_angle(error), self.turn_rate, self.limits
        if abs(error) > 2.5 and w * error < 0:
            error -= math.copysign(2 * math.pi, error)  # nearly behind: keep turning the same way
        if abs(error) < 1e-9:
            return 0.0
        side = math.copysign(1.0, error)
        rate = speed_within(abs(error), side * w, limits.turn_acceleration, h)
        return side * min(limits.turn_rate, rate)

    def _guard(self, v2: float, w2: float, h: float) -> tuple[float, float]:
        """The wanted speeds, cut so that from them the base can still stop in time.

        Kept safe by induction: from speeds this lets through, braking and straightening at
        the limits stays clear, so that is always a way out.
        """
        v, w = self.speed, self.turn_rate
        a, alpha = self.limits.acceleration, self.limits.turn_acceleration
        ahead = v > 0 or (v == 0 and v2 > 0)
        m, m2 = abs(v), abs(v2)
        heading = self.yaw if ahead else self.yaw + math.pi
        sweep = (w + w2) / 2 * h + w2 * abs(w2) / (2 * alpha)
        road, closing = self.clearance.free(self.x, self.y, heading, sweep, max(m, m2) / a)
        if m == 0 and road < 1e-4:
            return 0.0, w2  # no nibbling at the last tenth of a millimetre
        allowed = speed_within(road, m, a, h, closing)
        if m2 > allowed:
            least = max(0.0, m - a * h)
            if allowed < least - 1e-12:
                w2 = min(max(0.0, w - alpha * h), w + alpha * h)
            m2 = max(allowed, least)
        return (m2 if ahead else -m2), w2

    def _at_rim(self) -> bool:
        """Whether the goal is the person's space and the base stands at the edge of it."""
        clearance = self.clearance
        return (
            self.goal is not None
            and clearance.person is not None
            and clearance.within_keep(self.goal.x, self.goal.y)
            and clearance.distance(self.x, self.y) <= clearance.keep + RIM
        )
