"""The way a drawn greeter walks: from standing to standing, in closed form."""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass

from kendon.simulation.limbs import Curve, clip


@dataclass(frozen=True)
class Walk:
    """The way from the start to the stop: standing, walking, perhaps pausing, standing."""

    start: float  # [m] from the robot
    stop: float  # [m] from the robot
    speed: float  # [m/s]
    acceleration: float  # [m/s^2], setting off
    braking: float  # [m/s^2], coming to a stop
    sighting: float  # [s], how long they stand first
    pause_at: float  # [m] from the robot; NaN = they walk through
    pause: float  # [s]

    @property
    def _legs(self) -> list[tuple[float, float]]:
        """Time at which each leg begins and its length."""
        if math.isnan(self.pause_at):
            return [(self.sighting, self.start - self.stop)]
        first = self.start - self.pause_at
        second = self.sighting + self._seconds(first) + self.pause
        return [(self.sighting, first), (second, self.pause_at - self.stop)]

    def _top(self, length: float) -> float:
        """The highest speed on a leg that begins and ends at rest [m/s]."""
        return min(self.speed, math.sqrt(2 * length / (1 / self.acceleration + 1 / self.braking)))

    def _seconds(self, length: float) -> float:
        """How long such a leg takes."""
        top = self._top(length)
        ramps = top / self.acceleration + top / self.braking
        return ramps + (length - top * ramps / 2) / top

    @property
    def under_way(self) -> float:
        """When the person is seen to walk: at half the speed of the first leg.

        Who labels phases sees no approach in the first centimetres.
        """
        begin, length = self._legs[0]
        return begin + self._top(length) / 2 / self.acceleration

    @property
    def arrival(self) -> float:
        """When the person stands before the robot."""
        begin, length = self._legs[-1]
        return begin + self._seconds(length)

    def distance(self, t: Curve) -> Curve:
        """How far from the robot the person is at a time, or at times."""
        gone = 0.0 * t
        for begin, length in self._legs:
            whole, top = self._seconds(length), self._top(length)
            up, down = top / self.acceleration, top / self.braking
            since = clip(t - begin, 0.0, whole)
            early, late = clip(since, 0.0, up), clip(since - (whole - down), 0.0)
            cruise = clip(since - up, 0.0, whole - up - down)
            gone += self.acceleration * early * early / 2 + top * cruise
            gone += top * late - self.braking * late * late / 2
        return self.start - gone

    def time_at(self, distance: float) -> float:
        """When the person comes that near, to 0.02 s; when they set off if they start nearer."""
        steps = range(math.ceil((self.arrival - self.sighting) / 0.02) + 1)
        near = bisect_left(
            steps, True, key=lambda i: self.distance(self.sighting + i * 0.02) <= distance
        )
        return self.sighting + near * 0.02 if near < len(steps) else self.sighting
