"""The latest values of what is measured frame by frame, and what they come to over a while."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence

#: So long a value is kept [s]; it is let go of when twice as old.
KEPT = 3.2
#: Stamps are rounded to milliseconds or finer in files [s].
ROUNDED = 1e-3
#: The lower quartile of the absolute value of a standard normal variable.
QUARTILE = 0.3186


class Series:
    """Known values with their stamps, the oldest first.

    Lists, not arrays: a while is some ten frames long.
    """

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
        rounded_begin, rounded_end = begin - ROUNDED, end - ROUNDED
        return self.values[bisect_left(self.t, rounded_begin) : bisect_left(self.t, rounded_end)]

    def jitter(self, begin: float) -> float:
        """The standard deviation of values around a smooth course, from an instant on.

        Each value is compared with the line between its neighbours (Gasser, Sroka &
        Jennen-Steinmetz 1986); the quartile of those, as a wild value spoils three of them.

        Returns:
            NaN with fewer than three values.
        """
        first = bisect_left(self.t, begin - ROUNDED)
        t, x = self.t, self.values
        asides = []
        for i in range(first + 1, len(x) - 1):
            share = (t[i] - t[i - 1]) / (t[i + 1] - t[i - 1])
            rest = 1.0 - share
            aside = x[i] - rest * x[i - 1] - share * x[i + 1]
            asides.append(abs(aside) / math.sqrt(1.0 + share * share + rest * rest))
        if not asides:
            return math.nan
        asides.sort()
        return asides[(len(asides) - 1) // 4] / QUARTILE


def quantile(values: Sequence[float], share: float) -> float:
    """The value that a share of the values lies below; of the known ones, NaN of none.

    >>> quantile([3.0, 1.0, 2.0, 5.0, 4.0], 0.25)
    2.0
    """
    ordered = sorted([value for value in values if value == value])
    if not ordered:
        return math.nan
    place = share * (len(ordered) - 1)
    low = int(place)
    if low == place:
        return ordered[low]
    rest = place - low
    return (1.0 - rest) * ordered[low] + rest * ordered[low + 1]


def spread(values: Sequence[float]) -> float:
    """The standard deviation of values; of the known ones, NaN of fewer than four."""
    known = [value for value in values if value == value]
    count = len(known)
    if count < 4:
        return math.nan
    mean = sum(known) / count
    return math.sqrt(sum([(value - mean) ** 2 for value in known]) / count)
