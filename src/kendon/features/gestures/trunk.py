"""Bows: evidence from the trunk.

Bowing bends the trunk forward at the hips, by more than 15 degrees even in passing, and takes
face and shoulders down. Where the hips are not seen these have to do: who dips the head keeps the
shoulders where they were.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from kendon.features.gestures.evidence import Weighing
from kendon.features.gestures.head import turned
from kendon.features.gestures.series import Series, change, quantile
from kendon.geometry import Vec3

#: The trunk now is the median of so long [s].
NOW = 0.15
#: A person's usual way is the median from this long ago until this long ago [s].
HELD_FROM, HELD_UNTIL = 3.0, 0.6
#: So much must be known for that [s].
HELD_LEAST = 1.0


class BowEvidence(NamedTuple):
    """What speaks for a bow."""

    flexion: float
    drop: float
    sinks: float

    @property
    def of_trunk(self) -> tuple[float, float]:
        """What is told where the hips are seen."""
        return self.flexion, self.drop

    @property
    def of_height(self) -> tuple[float, float]:
        """What is told without them."""
        return self.drop, self.sinks


FLEXION = Weighing(math.radians(13), math.radians(2.5), -4.0, 5.0)  # from the usual [rad]
DROP = Weighing(0.06, 0.02, -1.0, 3.0)  # of the face, from the usual [m]
SINKS = Weighing(0.05, 0.02, -2.0, 3.0)  # of the shoulders, from the usual [m]


class Trunk:
    """The trunk over the latest seconds."""

    def __init__(self) -> None:
        self._flexion = Series()  # [rad], forward
        self._length = Series()  # [m], hips to shoulders
        self._height = Series()  # [m], of the face
        self._shoulders = Series()  # [m], their height
        self._yaw = Series()  # [rad], of the chest, from the way to the robot

    def clear(self) -> None:
        """Forget everything."""
        for series in (self._flexion, self._length, self._height, self._shoulders, self._yaw):
            series.clear()

    def add(self, t: float, head: Vec3, left: Vec3, right: Vec3, hips: tuple[Vec3, Vec3]) -> None:
        """Take in an instant: the face, the shoulders and the hips [m]; NaN when unknown."""
        self._height.add(t, head[2])
        self._shoulders.add(t, 0.5 * (left[2] + right[2]))
        hip_left, hip_right = hips
        x = (left[0] + right[0] - hip_left[0] - hip_right[0]) / 2.0
        y = (left[1] + right[1] - hip_left[1] - hip_right[1]) / 2.0
        z = (left[2] + right[2] - hip_left[2] - hip_right[2]) / 2.0
        # Forward is across the line from the right shoulder to the left.
        across_x, across_y = left[0] - right[0], left[1] - right[1]
        # The chest points to (across_y, -across_x), the robot is at -head.
        ahead = across_x * head[1] - across_y * head[0]
        self._yaw.add(t, math.atan2(across_x * head[0] + across_y * head[1], ahead))
        size = math.sqrt(across_x * across_x + across_y * across_y) or math.nan
        self._flexion.add(t, math.atan2((x * across_y - y * across_x) / size, z))
        self._length.add(t, math.sqrt(x * x + y * y + z * z))

    def flexion(self, end: float, since: float) -> float:
        """How far the trunk is bent forward from its usual way [rad]; NaN when unknown."""
        return self._from_usual(self._flexion, end, since)

    def aside(self, end: float, since: float) -> float:
        """How far from the robot the chest is turned [rad]; NaN when unknown."""
        return turned(self._yaw, end, since)

    def seen(self, since: float) -> bool:
        """Whether anything of it has been seen from an instant on."""
        return self._flexion.seen(since) or self._height.seen(since)

    def evidence(self, end: float, since: float, flexion: float) -> BowEvidence:
        """What the trunk does in an interval that ends at `end`, its first frame at `since`."""
        length = quantile(self._length.since(end - 1.0), 0.5)
        noise = change(self._length.since(end - 1.0)) / length if length > 0.0 else 0.0
        face, shoulders = self._height, self._shoulders
        return BowEvidence(
            FLEXION.evidence(flexion, noise),
            DROP.evidence(-self._from_usual(face, end, since), change(face.since(end - 1.0))),
            SINKS.evidence(
                -self._from_usual(shoulders, end, since), change(shoulders.since(end - 1.0))
            ),
        )

    @staticmethod
    def _from_usual(series: Series, end: float, since: float) -> float:
        now = quantile(series.since(min(end - NOW, since)), 0.5)
        return now - series.usual(end - HELD_FROM, end - HELD_UNTIL, HELD_LEAST)
