"""Where a base may drive: not into the greeted person, not off its leash.

The answer to every question is a length of free road, so that one rule (brake within what is
free) keeps the base out of the person's space and inside its leash alike.
"""

from __future__ import annotations

import math

from kendon.geometry import Pose2D, Vec3, wrap_angle

#: A person's speed is read off over at most this long [s]: two frames at the 5 Hz of the
#: observations, so that a person whose track has gone quiet soon counts as standing.
MEMORY = 0.4
#: A jump of the track that looks faster than this is no walk [m/s]; people greet at up to
#: about 2 m/s, and one bad frame must not freeze the base.
FASTEST_WALK = 2.5
#: How much wider than the keep distance the base swings around a person in its way [m].
DETOUR_MARGIN = 0.05


class Clearance:
    """The person to keep away from and the leash to stay on.

    Args:
        keep_distance: how near the base's centre may drive to the person, ground plane [m].
        start: where the leash is tied.
        leash: how far the base's centre may get from `start` [m]; None is no leash.
    """

    __slots__ = (
        "_moved", "_start_x", "_start_y", "keep", "leash", "person", "person_vx", "person_vy",
    )  # fmt: skip

    def __init__(self, keep_distance: float, start: Pose2D, leash: float | None) -> None:
        self.keep = keep_distance
        self.leash = leash
        self.person: tuple[float, float] | None = None  # [m], ground plane, world
        self.person_vx = 0.0  # [m/s]
        self.person_vy = 0.0
        self._moved = 0.0  # [s], when the person was last seen to move
        self._start_x, self._start_y = start.x, start.y

    def observe(self, person: Vec3 | None, t: float) -> None:
        """Take note of where the person is at `t` [s], and from that how they walk.

        A position that is not finite counts as no person.
        """
        if person is None or not (math.isfinite(person[0]) and math.isfinite(person[1])):
            self.person = None
            self.person_vx = self.person_vy = 0.0
            return
        old, self.person = self.person, (person[0], person[1])
        if old is None:
            self.person_vx, self.person_vy, self._moved = 0.0, 0.0, t
        elif old != self.person:
            dt = min(t - self._moved, MEMORY)
            vx, vy = 0.0, 0.0
            if dt > 0:
                vx, vy = (person[0] - old[0]) / dt, (person[1] - old[1]) / dt
            scale = max(1.0, math.hypot(vx, vy) / FASTEST_WALK)
            self.person_vx, self.person_vy, self._moved = vx / scale, vy / scale, t
        elif t - self._moved >= MEMORY:
            self.person_vx = self.person_vy = 0.0

    def free(
        self, x: float, y: float, heading: float, sweep: float, braking: float
    ) -> tuple[float, float]:
        """The road that is free for a base that leaves (x, y) and brakes.

        Args:
            x: the base's centre in the world [m].
            y: likewise [m].
            heading: the direction it moves in [rad].
            sweep: how much further that direction may still turn, signed [rad].
            braking: how long it needs to stand [s].

        Returns:
            The length of every path that bends by no more than `sweep` and surely stays
            clear [m], inf if there is no end to it; and how fast the person shortens it [m/s].
        """
        road, closing = math.inf, 0.0
        if self.person is not None:
            dx, dy = self.person[0] - x, self.person[1] - y
            d = math.hypot(dx, dy)
            off = _outside(wrap_angle(math.atan2(dy, dx) - heading), sweep)
            if self.person_vx or self.person_vy:
                radial = (dx * self.person_vx + dy * self.person_vy) / max(d, 1e-9)
                crossing = abs(dx * self.person_vy - dy * self.person_vx) / max(d, 1e-9)
                # While the base brakes, the person may step into the way from the side.
                off = max(0.0, off - crossing * braking / max(d, self.keep))
                closing = max(0.0, -radial)
            if off < math.pi / 2:
                aside = d * math.sin(off)
                if d <= self.keep:
                    road = 0.0
                elif aside < self.keep:
                    road = d * math.cos(off) - math.sqrt(self.keep**2 - aside**2)
        if self.leash is not None:
            dx, dy = x - self._start_x, y - self._start_y
            d = math.hypot(dx, dy)
            off = _outside(wrap_angle(math.atan2(dy, dx) - heading), sweep) if d > 0 else 0.0
            aside = d * math.sin(off)
            left = math.sqrt(max(0.0, self.leash**2 - aside**2)) - d * math.cos(off)
            if left < road:
                road, closing = max(0.0, left), 0.0
        return road, closing

    def clip(self, x: float, y: float, goal: Pose2D) -> tuple[Pose2D, str]:
        """The goal a base at (x, y) may really drive to, and why it differs ("" if not).

        The leash moves a goal to the nearest point of its disc; the person moves one that
        lies within the keep distance back along the line from the base to the last allowed
        point, which is where the base stands if the person is nearer than that already.
        """
        gx, gy, why = goal.x, goal.y, ""
        if self.leash is not None:
            dx, dy = gx - self._start_x, gy - self._start_y
            d = math.hypot(dx, dy)
            if d > self.leash:
                share = self.leash / d
                gx, gy = self._start_x + share * dx, self._start_y + share * dy
                why = f"the goal lay beyond the leash of {self.leash:g} m"
        if self.within_keep(gx, gy):
            dx, dy = gx - x, gy - y
            length = math.hypot(dx, dy)
            road = 0.0
            if length > 0 and not self.within_keep(x, y):
                road = min(length, self.free(x, y, math.atan2(dy, dx), 0.0, 0.0)[0])
                gx, gy = x + dx * road / length, y + dy * road / length
            else:
                gx, gy = x, y
            why = f"the goal lay within {self.keep:g} m of the person"
        return (Pose2D(gx, gy, goal.yaw), why) if why else (goal, "")

    def distance(self, x: float, y: float) -> float:
        """From (x, y) to the person over the ground [m]; inf when there is none."""
        if self.person is None:
            return math.inf
        return math.hypot(self.person[0] - x, self.person[1] - y)

    def within_keep(self, x: float, y: float) -> bool:
        """Whether (x, y) is too near to the person to stop there (by more than 1 um)."""
        return self.distance(x, y) < self.keep - 1e-6

    def bearing(self, x: float, y: float, goal_x: float, goal_y: float) -> float:
        """Which way to drive from (x, y) toward a goal [rad].

        Straight, or along the tangent around the person who stands in the way. With the
        person already nearer than the keep distance, straight: the base then stands and
        waits rather than squeeze past.
        """
        dx, dy = goal_x - x, goal_y - y
        straight = math.atan2(dy, dx)
        if self.person is None or self.within_keep(goal_x, goal_y):
            return straight
        px, py = self.person[0] - x, self.person[1] - y
        length, d = math.hypot(dx, dy), math.hypot(px, py)
        along, across = (px * dx + py * dy) / length, (dx * py - dy * px) / length
        slack = 0.005  # [m]: a goal on the rim must not be circled because of rounding
        if not (0 < along < length and abs(across) < self.keep - slack < d):
            return straight
        rim = self.keep + DETOUR_MARGIN
        # On the rim itself a little outward, else every step would graze the person's space.
        swing = math.asin(rim / d) if d > rim else math.pi / 2 + 0.1
        return math.atan2(py, px) - math.copysign(swing, across)


def _outside(angle: float, sweep: float) -> float:
    """How far an angle lies outside the cone between 0 and `sweep` [rad]."""
    low, high = (sweep, 0.0) if sweep < 0 else (0.0, sweep)
    if angle < low:
        return min(math.pi, low - angle)
    return min(math.pi, angle - high) if angle > high else 0.0
