"""Head tosses, nods and head dips: evidence from where the face points.

The pitch is taken from the person's own recent way of holding the head, since cameras are
mounted askew and people look at the ground while they walk. A dip goes down by more than twenty
degrees and comes up within a second, straight ahead; a look aside turns the head. A nod is small,
quick and repeated; a toss goes up and comes back. A bow is none of them: there the trunk takes
the head along.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from kendon.features.gestures.evidence import Weighing
from kendon.features.gestures.series import Series, quantile
from kendon.geometry import Quaternion, Vec3, wrap_angle

#: The pitch now is the median of so long [s].
NOW = 0.2
#: A head is held as it was in the median from this long ago until this long ago [s].
HELD_FROM, HELD_UNTIL = 2.4, 0.4
#: So much must be known for that [s].
HELD_LEAST = 0.8
#: How uncertain it is otherwise how somebody holds the head [rad].
UNSURE = math.radians(12)
#: A toss or a nod is over in so long [s].
BEAT = 0.8
#: A beat of the head is smoothed over so long: a third of a quick nod [s].
SMOOTH = 0.1
#: A trunk may bend by so much in walking; what is more it takes from the head's pitch [rad].
WALKING = math.radians(8)
#: What goes farther down and comes back is a dip, no nod [rad].
DEEPEST_NOD = math.radians(22)
#: The noise that is assumed while there are too few frames to estimate it [rad].
PRIOR_NOISE = math.radians(5)
#: Standard error of a median over that of the mean, for normal noise.
INEFFICIENCY = 1.25
#: The middle of nine normal values lies so many standard deviations from the least of them, and
#: what is before and behind it about as many the other way.
EXTREMES = 2.0


class DipEvidence(NamedTuple):
    """What speaks for a head dip."""

    down: float
    floor: float
    aside: float
    brief: float


class NodEvidence(NamedTuple):
    """What speaks for a nod or a toss."""

    up: float
    down: float


DOWN = Weighing(math.radians(15), math.radians(3.0), -4.0, 8.0)  # from the usual [rad]
FLOOR = Weighing(math.radians(18), math.radians(5.0), -2.0, 2.0)  # from the horizontal [rad]
ASIDE = Weighing(math.radians(15), math.radians(-6.0), -3.0, 1.0)  # from the usual yaw [rad]
BRIEF = Weighing(math.radians(12), math.radians(-4.0), -3.0, 1.0)  # down a second ago [rad]
TOSS = Weighing(math.radians(8), math.radians(2.0), -2.0, 6.0)  # up and back [rad]
NOD = Weighing(math.radians(8), math.radians(2.0), -2.0, 6.0)  # down and back [rad]


class Head:
    """Where the face points over the latest seconds."""

    def __init__(self) -> None:
        self._pitch = Series()  # [rad], down is positive
        self._yaw = Series()  # [rad], from the way to the robot

    def clear(self) -> None:
        """Forget everything."""
        self._pitch.clear()
        self._yaw.clear()

    def add(self, t: float, head: Vec3, rotation: Quaternion) -> None:
        """Take in the face and the head's orientation at an instant; NaN when unknown."""
        x, y, z, w = rotation
        size = x * x + y * y + z * z + w * w
        if not size > 0.0:
            return
        down = 2.0 * (w * y - x * z) / size
        self._pitch.add(t, math.asin(min(1.0, max(-1.0, down))))
        facing = math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
        self._yaw.add(t, wrap_angle(facing - math.atan2(-head[1], -head[0])))

    def seen(self, since: float) -> bool:
        """Whether the head's orientation has been seen from an instant on."""
        return self._pitch.seen(since)

    def evidence(self, end: float, since: float, flexion: float) -> tuple[DipEvidence, NodEvidence]:
        """What the head does in an interval in which it is seen.

        Args:
            end: of the interval [s].
            since: its first frame [s].
            flexion: how far the trunk is bent forward from its usual way; NaN when unknown [rad].
        """
        begin = min(end - NOW, since)
        pitches = self._pitch.since(begin)
        jitter = self._pitch.jitter(end - 1.0)
        noise = jitter if jitter == jitter else PRIOR_NOISE
        noise_now = INEFFICIENCY * noise / math.sqrt(len(pitches))
        usual = self._pitch.usual(end - HELD_FROM, end - HELD_UNTIL, HELD_LEAST)
        unsure = noise_now
        if usual != usual:
            usual, unsure = 0.0, math.hypot(noise_now, UNSURE)
        taken_along = flexion - WALKING if flexion > WALKING else 0.0
        pitch = quantile(pitches, 0.5)
        # Half a second and more ago, a dip had hardly begun.
        before = quantile(self._pitch.between(end - 1.2, end - 0.8), 0.5)
        yaw = quantile(self._yaw.since(begin), 0.5)
        usual_yaw = self._yaw.usual(end - HELD_FROM, end - HELD_UNTIL, HELD_LEAST)
        dip = DipEvidence(
            DOWN.evidence(pitch - usual - taken_along, unsure),
            FLOOR.evidence(pitch - taken_along, noise_now),
            ASIDE.evidence(abs(yaw - usual_yaw), noise_now),
            BRIEF.evidence(before - usual, unsure),
        )
        up, down, unsure = self._beat(end, noise)
        return dip, NodEvidence(TOSS.evidence(up, unsure), NOD.evidence(down, unsure))

    def _beat(self, end: float, noise: float) -> tuple[float, float, float]:
        """How far the head went up and came back, and down and back, in the last beat [rad].

        Behind them what noise there is in them. The extremes of noise are a beat, too: that much
        is taken off.
        """
        count = round(BEAT / SMOOTH)
        steps = [
            self._pitch.between(end - (k + 1) * SMOOTH, end - k * SMOOTH)
            for k in range(count, -1, -1)
        ]
        known = [quantile(step, 0.5) for step in steps if step]
        if len(known) < 4:
            return math.nan, math.nan, 0.0
        unsure = INEFFICIENCY * noise * math.sqrt(len(known) / sum(map(len, steps)))
        up = down = 0.0
        for i in range(1, len(known) - 1):
            before, after = known[:i], known[i + 1 :]
            up = max(up, min(max(before), max(after)) - known[i])
            down = max(down, known[i] - max(min(before), min(after)))
        up, down = max(0.0, up - EXTREMES * unsure), max(0.0, down - EXTREMES * unsure)
        return up, down if down < DEEPEST_NOD else 0.0, unsure
