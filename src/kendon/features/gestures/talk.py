"""Whether somebody near has been talking with their hands: then one that is up mostly talks on."""

from __future__ import annotations

import math
from collections.abc import Sequence

from kendon.features.gestures.arm import Arm
from kendon.features.gestures.evidence import Weighing
from kendon.features.gestures.series import Series

#: Who is farther off talks to nobody [m]: the near phase of social distance (Hall 1966).
NEAR = 2.1
#: So long before a gesture is looked at [s], and so much of that must be known [intervals].
BEFORE, LEAST = 6.0, 10
#: A hand that goes so far in a while talks, one that goes half as far is in between [arms].
STIRS = 0.25

TALKED = Weighing(0.25, -0.10, -6.0, 0.5)  # share of the time in which hands have stirred


class Talk:
    """How much a person's hands have stirred over the latest seconds, near by."""

    def __init__(self) -> None:
        self._stirred = Series(kept=2 * BEFORE)  # gestures last for some seconds, too

    def clear(self) -> None:
        """Forget everything."""
        self._stirred.clear()

    def add(self, end: float, arms: Sequence[Arm], arm: float, distance: float) -> None:
        """Take in what hands do in an interval; its end [s], the arms' length and distance [m]."""
        if distance < NEAR:
            self._stirred.add(end, min(1.0, max(one.stirs(end, arm) for one in arms) / STIRS))

    def greeted(self, end: float) -> None:
        """The hands have greeted in the interval that ended then [s].

        They were on their way before anyone could tell: all of their stirring up to now, since
        they last rested, was no talk.
        """
        if self._stirred.seen(end):
            values = self._stirred.values
            last = len(values) - 1
            while last >= 0 and values[last] > 0:
                values[last] = 0.0
                last -= 1

    def evidence(self, begin: float) -> float:
        """What the time before a gesture that began at an instant says; NaN when unknown."""
        stirred = self._stirred.between(begin - BEFORE, begin)
        if len(stirred) < LEAST:
            return math.nan
        return TALKED.evidence(sum(stirred) / len(stirred))
