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
#: So many values tell well enough what is usual.
ENOUGH = 20
#: The median of the absolute value of a standard normal variable, and its lower quartile.
MEDIAN, QUARTILE = 0.6745, 0.3186


class Series:
    """Known values with their stamps over the latest seconds, the oldest first.

    Args:
        kept: for how long at least [s].
    """

    __slots__ = ("kept", "t", "values")

    def __init__(self, kept: float = KEPT) -> None:
        self.kept = kept
        self.t: list[float] = []  # [s]
        self.values: list[float] = []

    def clear(self) -> None:
        """Forget everything."""
        self.t.clear()
        self.values.clear()

    def add(self, t: float, value: float) -> None:
        """Take in a value; one that is not known, or beyond all measure, is passed over."""
        if not math.isfinite(value):
            return
        stamps = self.t
        if stamps and t - stamps[0] > 2 * self.kept:
            old = bisect_left(stamps, t - self.kept)
            del stamps[:old], self.values[:old]
        stamps.append(t)
        self.values.append(value)

    def first(self, begin: float) -> int:
        """The place of the first value from an instant on [s]."""
        return bisect_left(self.t, begin - ROUNDED)

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
        """The median between two instants; NaN where less than `least` before the end is known.

        Of many values every second or third will do: what is usual is no matter of single frames.
        """
        first = self.first(begin)
        if first == len(self.t) or end - self.t[first] < least:
            return math.nan
        values = self.between(begin, end)
        return quantile(values[:: 1 + len(values) // ENOUGH], 0.5)

    def wander(self, begin: float) -> float:
        """How far values go from the usual: half of what two thirds of them lie within."""
        values = self.since(begin)
        ordered = sorted(values[:: 1 + len(values) // ENOUGH])
        sixth = len(ordered) // 6
        return 0.5 * (ordered[-1 - sixth] - ordered[sixth]) if ordered else math.nan

    def range(self, begin: float, end: float) -> float:
        """What most of the values between two instants lie within: from tenth to tenth.

        Returns:
            NaN of fewer than three values.
        """
        values = self.between(begin, end)
        if len(values) < 3:
            return math.nan
        return quantile(values, 0.9) - quantile(values, 0.1)

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
    whole = sum(values)
    if whole != whole:  # sorting would be lost on NaN
        values = [value for value in values if value == value]
    ordered = sorted(values)
    if not ordered:
        return math.nan
    place = share * (len(ordered) - 1)
    low = int(place)
    rest = place - low
    return (1.0 - rest) * ordered[low] + rest * ordered[low + 1] if rest else ordered[low]


def spread(values: Sequence[float]) -> float:
    """The standard deviation of known values; NaN of fewer than four."""
    count = len(values)
    if count < 4:
        return math.nan
    mean = sum(values) / count
    return math.sqrt(sum([(value - mean) ** 2 for value in values]) / count)


def to_and_fro(values: Sequence[float]) -> float:
    """How far values go one way and come back, or the other way round; NaN of fewer than four.

    >>> to_and_fro([0.0, 3.0, 5.0, 4.0, 3.0])
    2.0
    """
    if len(values) < 4:
        return math.nan
    low = high = values[0]
    rise = fall = 0.0
    for value in values:
        if value < low:
            low = value
        elif value > high:
            high = value
        if value - low > rise:
            rise = value - low
        if high - value > fall:
            fall = high - value
    return min(rise, fall)


def change(values: Sequence[float]) -> float:
    """The noise of something that stays the same, from one value to the next; 0 when unknown."""
    steps = [abs(b - a) for a, b in pairwise(values)]
    step = quantile(steps, 0.5)
    return step / (MEDIAN * math.sqrt(2.0)) if step == step else 0.0
