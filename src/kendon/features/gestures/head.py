"""Head tosses, nods and head dips, from the head's pitch.

The pitch is taken from the person's own recent way of holding the head, since cameras are
mounted askew and people look at the ground while they walk. A dip goes down by more than twenty
degrees and comes up within a second; a nod is small, quick and repeated; a toss goes up and
comes back. A bow is none of them: there the trunk takes the head along.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from kendon.features.gestures.evidence import Weighing, posterior
from kendon.features.gestures.series import Series, quantile
from kendon.geometry import Quaternion

#: Probabilities in any 0.2 s of an encounter.
DIP_PRIOR = 0.05
NOD_PRIOR = 0.03

#: The pitch now is the median of so long [s].
NOW = 0.2
#: A head is held as it was in the median from this long ago until this long ago [s].
HELD_FROM, HELD_UNTIL = 2.4, 0.4
#: So much of that while must be known for a baseline [s].
HELD_LEAST = 0.5
#: A toss or a nod is over in so long [s].
BEAT = 0.8
#: A beat of the head is smoothed over so long: a third of a quick nod [s].
SMOOTH = 0.1

DIP = Weighing(math.radians(13), math.radians(2.5), -4.0, 6.0)  # down from the baseline [rad]
TOSS = Weighing(math.radians(9), math.radians(2.0), -2.0, 4.5)  # up and back [rad]
NOD = Weighing(math.radians(9), math.radians(2.0), -2.0, 4.5)  # down and back [rad]


class HeadGestures(NamedTuple):
    """Probabilities of what the head does; NaN = unknown."""

    nod: float  # a nod or a toss
    dip: float


class Head:
    """The head's pitch over the latest seconds."""

    def __init__(self) -> None:
        self._pitch = Series()  # [rad], down is positive

    def clear(self) -> None:
        """Forget everything."""
        self._pitch.clear()

    def add(self, t: float, rotation: Quaternion) -> None:
        """Take in the head's orientation at an instant; NaN when unknown."""
        x, y, z, w = rotation
        size = x * x + y * y + z * z + w * w
        if size > 0.0:
            down = 2.0 * (w * y - x * z) / size
            self._pitch.add(t, math.asin(min(1.0, max(-1.0, down))))

    def gestures(self, end: float, since: float, flexion: float) -> HeadGestures:
        """What the head does in an interval.

        Args:
            end: of the interval [s].
            since: its first frame [s].
            flexion: how far the trunk is bent forward from its usual way; NaN when unknown [rad].
        """
        pitches = self._pitch.since(min(end - NOW, since))
        if not self._pitch.since(since):
            return HeadGestures(math.nan, math.nan)
        jitter = self._pitch.jitter(end - 1.0)
        noise = 1.25 * (jitter if jitter == jitter else math.radians(5)) / math.sqrt(len(pitches))
        held = self._pitch.between(end - HELD_FROM, end - HELD_UNTIL)
        if not held or self._pitch.t[-1] - self._pitch.t[0] < HELD_LEAST + HELD_UNTIL:
            usual, unsure = 0.0, math.radians(12)
        else:
            usual, unsure = quantile(held, 0.5), 0.0
        bent = flexion if flexion > 0.0 else 0.0
        down = quantile(pitches, 0.5) - usual - bent
        dip = posterior(DIP_PRIOR, [DIP.evidence(down, math.hypot(noise, unsure))])

        up_and_back, down_and_back = self._beat(end)
        nod = posterior(
            NOD_PRIOR,
            [
                max(
                    TOSS.evidence(up_and_back, 1.5 * noise),
                    NOD.evidence(down_and_back, 1.5 * noise),
                )
            ],
        )
        return HeadGestures(nod, dip)

    def _beat(self, end: float) -> tuple[float, float]:
        """How far the head went up and came back, and down and back, in the last beat [rad]."""
        smooth = [
            quantile(self._pitch.between(end - (k + 1) * SMOOTH, end - k * SMOOTH), 0.5)
            for k in range(round(BEAT / SMOOTH), -1, -1)
        ]
        known = [value for value in smooth if value == value]
        if len(known) < 4:
            return math.nan, math.nan
        up = down = 0.0
        for i in range(1, len(known) - 1):
            before, after = known[:i], known[i + 1 :]
            up = max(up, min(max(before), max(after)) - known[i])
            down = max(down, known[i] - max(min(before), min(after)))
        return up, down
