"""Bows, from the trunk.

Bowing bends the trunk forward at the hips, by more than 15 degrees even in passing, and takes
the head down and forward. Where the hips are not seen the head's height alone has to do.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from kendon.features.gestures.evidence import Weighing, posterior
from kendon.features.gestures.series import Series, quantile
from kendon.geometry import Vec3

#: Probability in any 0.2 s of an encounter.
BOW_PRIOR = 0.03
#: The trunk now is the median of so long [s].
NOW = 0.25
#: A person's usual way is the median from this long ago until this long ago [s].
HELD_FROM, HELD_UNTIL = 3.0, 0.6
#: So much of that while must be known [s].
HELD_LEAST = 0.4

FLEXION = Weighing(math.radians(18), math.radians(3.5), -4.0, 6.0)  # from the usual [rad]
DROP = Weighing(0.12, 0.03, -2.0, 3.0)  # of the head, from the usual [m]


class TrunkGestures(NamedTuple):
    """What the trunk does; NaN = unknown."""

    bow: float  # probability
    flexion: float  # forward from the person's usual way [rad]


class Trunk:
    """The trunk over the latest seconds."""

    def __init__(self) -> None:
        self._flexion = Series()  # [rad], toward the robot
        self._length = Series()  # [m], hips to shoulders
        self._height = Series()  # [m], of the face

    def clear(self) -> None:
        """Forget everything."""
        for series in (self._flexion, self._length, self._height):
            series.clear()

    def add(self, t: float, head: Vec3, shoulders: Vec3, hips: Vec3, forward: Vec3) -> None:
        """Take in an instant: the face, the middle of shoulders and hips, the way ahead."""
        self._height.add(t, head[2])
        x, y, z = shoulders[0] - hips[0], shoulders[1] - hips[1], shoulders[2] - hips[2]
        ahead = x * forward[0] + y * forward[1]
        self._flexion.add(t, math.atan2(ahead, z))
        self._length.add(t, math.sqrt(x * x + y * y + z * z))

    def gestures(self, end: float, since: float) -> TrunkGestures:
        """What the trunk does in an interval that ends at `end`, its first frame at `since`."""
        begin = min(end - NOW, since)
        flexion = self._from_usual(self._flexion, begin, end)
        if not self._flexion.since(since):
            return TrunkGestures(math.nan, math.nan)
        lengths = self._length.since(end - 1.0)
        middle = quantile(lengths, 0.5)
        spread = quantile([abs(length - middle) for length in lengths], 0.5) / 0.6745
        noise = spread / max(middle, 0.2)
        drop = -self._from_usual(self._height, begin, end)
        bow = posterior(
            BOW_PRIOR, (FLEXION.evidence(flexion, noise), DROP.evidence(drop, 0.02))
        )
        return TrunkGestures(bow, flexion)

    @staticmethod
    def _from_usual(series: Series, begin: float, end: float) -> float:
        held = series.between(end - HELD_FROM, end - HELD_UNTIL)
        if not held or series.t[-1] - series.t[0] < HELD_LEAST + HELD_UNTIL:
            return math.nan
        return quantile(series.since(begin), 0.5) - quantile(held, 0.5)
