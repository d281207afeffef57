"""What values come to over a while: lists, not arrays, as a while is some ten frames long."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from itertools import pairwise

#: So long a value is kept [s]; it is let go of when twice as old.
KEPT = 3.2
#: Stamps are rounded to milliseconds or finer in files [s].
ROUNDED = 1e-3
#: The median of the absolute value of a standard normal variable, and its lower quartile.
MEDIAN, QUARTILE = 0.6745, 0.3186


class Series:
    """Known values with their stamps over the latest seconds, the oldest first."""

    __slots__ = ("t", "values")

    def __init__(self) -> None:
        self.t: list[float] = []  # [s]
        self.values: list[float] = []

    def clear(self) -> None:
        """Forget everything."""
        self.t.clear()
        self.values.clear()

    def add(self, t: float, value: float) -> None:
        """Take in a value; one that is not known is passed over."""
        if value != value:  # NaN is unequal to itself
            return
        stamps = self.t
        if stamps and t - stamps[0] > 2 * KEPT:
            old = bisect_left(stamps, t - KEPT)
            del stamps[:old], self.values[:old]
        stamps.append(t)
        self.values.append(value)

    def since(self, begin: float) -> list[float]:
        """The values from an instant on [s]."""
        return self.values[bisect_left(self.t, begin - ROUNDED) :]

    def between(self, begin: float, end: float) -> list[float]:
        """The values from an instant on and before another [s]."""
        first = bisect_left(self.t, begin - ROUNDED)
        return self.values[first : bisect_left(self.t, end - ROUNDED, first)]

    def seen(self, since: float) -> bool:
        """Whether there is a value from an instant on."""
        return bool(self.t) and self.t[-1] >= since - ROUNDED

    def usual(self, begin: float, end: float, least: float) -> float:
        """The median between two instants; NaN where less than `least` before the end is known."""
        if not self.t or end - self.t[0] < least:
            return math.nan
        return quantile(self.between(begin, end), 0.5)

    def jitter(self, begin: float) -> float:
        """The standard deviation of values around a smooth course, from an instant on.

        Each value is compared with the middle of its neighbours (Gasser, Sroka &
        Jennen-Steinmetz 1986); the quartile of those, as a wild value spoils three of them.

        Returns:
            NaN with fewer than three values.
        """
        x = self.since(begin)
        if len(x) < 3:
            return math.nan
        asides = sorted([abs(b - 0.5 * (a + c)) for a, b, c in zip(x, x[1:], x[2:], strict=False)])
        return asides[(len(asides) - 1) // 4] / (QUARTILE * math.sqrt(1.5))


def quantile(values: Sequence[float], share: float) -> float:
    """The value that a share of the values lies below; of the known ones, NaN of none.

    >>> quantile([3.0, 1.0, 2.0, 5.0, 4.0], 0.25)
    2.0
    """
    ordered = [value for value in values if value == value]
    if not ordered:
        return math.nan
    ordered.sort()
    place = share * (len(ordered) - 1)
    low = int(place)
    rest = place - low
    return (1.0 - rest) * ordered[low] + rest * ordered[low + 1] if rest else ordered[low]


def spread(values: Sequence[float]) -> float:
    """The standard deviation of values; of the known ones, NaN of fewer than four."""
    known = [value for value in values if value == value]
    count = len(known)
    if count < 4:
        return math.nan
    mean = sum(known) / count
    return math.sqrt(sum([(value - mean) ** 2 for value in known]) / count)


def change(values: Sequence[float]) -> float:
    """The noise of something that stays the same, from one value to the next; 0 when unknown."""
    steps = [abs(b - a) for a, b in pairwise(values)]
    step = quantile(steps, 0.5)
    return step / (MEDIAN * math.sqrt(2.0)) if step == step else 0.0
