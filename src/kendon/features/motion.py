"""How fast a person closes in, from noisy positions (thesis 3.3.2).

The thesis divides the way between two observations by the time between them (3.2-3.3). With a
camera's noise of a few per cent that is worth little at eight metres, and it lags behind by an
interval. Here the same speed is read off a line laid robustly through the latest positions: the
fewer positions, the quicker it follows; so each time the shortest stretch is taken over which the
noise, estimated from the positions themselves, leaves the slope sure enough (adaptive windowing,
after Janabi-Sharifi, Hayward & Chen 2000). What a slope leaves open the head's rise and fall tells
(`kendon.features.gait`). One that says next to nothing is unknown.

Somebody who is lost for less than a second and comes back near by has gone on meanwhile: the line
goes on through the positions of before, whose age does not count the time out of sight.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from kendon.features.gait import QUARTILE, ROUNDED, likely_speed
from kendon.features.proxemics import closing_speed

#: The stretches a line may be laid through [s], the quickest first.
WINDOWS = (0.2, 0.3, 0.4, 0.6)
#: A slope whose standard error is below this is sure enough: less than by what those who stand
#: vary, so that it tells them from those who walk their last slow steps [m/s].
SURE = 0.1
#: One whose standard error is below this decides alone: no gait is told more exactly [m/s].
CERTAIN = 0.02
#: One whose standard error is above this says nothing by itself, nearly a walker's speed, and above
#: that nothing even with what the head does [m/s].
UNSURE, HOPELESS = 1.0, 1.5
#: So far back the noise is estimated from [s].
NOISE_SPAN = 1.0
#: The noise that is assumed while there are too few positions to estimate it: a head sways [m].
PRIOR_NOISE = 0.02
#: Standard error of repeated medians over that of least squares, for normal noise.
INEFFICIENCY = 1.25
#: Who is back so soon [s], no farther away than a runner comes [m/s], was out of sight only.
BRIDGED, FASTEST = 1.0, 3.0
#: Positions this old are never looked at again [s]; they are let go of when twice as old.
_KEPT = BRIDGED + NOISE_SPAN


class Walk:
    """Where a person was of late on the ground of the world, and the robot.

    Lists and loops, not arrays: a line through seven positions is too little for array arithmetic
    to pay, and the features of a live person are computed here five times a second. Only where
    the line is not sure are there arrays, of heights.
    """

    def __init__(self) -> None:
        self._t: list[float] = []  # [s]
        self._seen: list[float] = []  # [s], the same without the time the person was lost
        self._x: list[float] = []  # [m], of the person
        self._y: list[float] = []
        self._z: list[float] = []  # NaN where the height is unknown
        self._robot: list[tuple[float, float]] = []  # [m]
        self._aside: list[float] = []  # [m], of all positions but the first and the last

        self._lost = False  # whether an interval has passed without a position
        self._away = 0.0  # [s], how long such intervals lasted since the first position

    def clear(self) -> None:
        """Somebody else: what was before says nothing of what comes."""
        for column in self._columns():
            column.clear()
        self._lost, self._away = False, 0.0

    def lose(self) -> None:
        """The person has been lost for an interval: maybe for good, maybe not."""
        self._lost = True

    def add(self, t: float, x: float, y: float, z: float, robot: tuple[float, float]) -> None:
        """Take in the next position, known and finite but for z, the head's height."""
        if self._lost and self._t:
            away = t - self._t[-1]
            dx, dy = x - self._x[-1], y - self._y[-1]
            if away <= BRIDGED and math.sqrt(dx * dx + dy * dy) <= FASTEST * away:
                self._away += away
            else:
                self.clear()
        self._lost = False
        if self._t and t - self._t[0] > 2 * _KEPT:
            # The one before all that are kept stays: the first of them is off the path from it.
            old = bisect_left(self._t, t - _KEPT) - 1
            for column in self._columns():
                del column[:old]
        self._t.append(t)
        self._seen.append(t - self._away)
        self._x.append(x)
        self._y.append(y)
        self._z.append(z)
        self._robot.append(robot)
        if len(self._t) > 2:
            self._aside.append(self._off_the_path())

    def _columns(self) -> tuple[list[float] | list[tuple[float, float]], ...]:
        return (
            self._t, self._seen, self._x, self._y, self._z, self._robot, self._aside
        )  # fmt: skip

    def speed(self, end: float, period: float) -> float:
        """The person's speed toward where the robot was one period before `end` [m/s].

        Args:
            end: the instant, at or after the newest position [s].
            period: the interval between observations [s].

        Returns:
            Positive when coming closer; NaN where it is not sure enough.
        """
        begin, error = self._line_from(end, period)
        if error > HOPELESS:
            return math.nan
        t, x, y = self._t[begin:], self._x[begin:], self._y[begin:]
        # Where the lines are now and were a period before, in both directions.
        now, before = _ends_of_lines(t, x, y, end, period)
        then = max(bisect_right(t, end - period + ROUNDED) - 1, 0)
        slope = closing_speed(before, now, self._robot[begin + then], period)
        if error <= CERTAIN:
            return slope
        aside = math.sqrt(max((math.dist(now, before) / period) ** 2 - slope * slope, 0.0))
        latest = bisect_left(self._t, end - NOISE_SPAN - ROUNDED)
        stamps, heights = np.array(self._t[latest:]), np.array(self._z[latest:])
        likely = float(likely_speed(slope, error, aside, stamps, heights, end))
        if math.isnan(likely):
            return slope if error <= UNSURE else math.nan
        return likely

    def _line_from(self, end: float, period: float) -> tuple[int, float]:
        """The first position of the shortest line that is sure enough, else of the surest.

        Returns:
            Where it begins, and its slope's standard error [m/s]; infinite if there is none.
        """
        stamps, seen = self._t, self._seen
        noise = self._noise(end)
        best, least = 0, math.inf
        for window in WINDOWS:
            begin = bisect_left(seen, end - self._away - window - ROUNDED)
            begin = max(begin, bisect_left(stamps, end - BRIDGED - window - ROUNDED))
            count = len(stamps) - begin
            if count < 2:
                continue
            span = stamps[-1] - stamps[begin]
            if span < period / 2:
                continue
            error = INEFFICIENCY * noise * math.sqrt(12 / count) / span
            if error <= SURE:
                return begin, error
            if error < least:
                best, least = begin, error
        return best, least

    def _noise(self, end: float) -> float:
        """The standard deviation of the positions around a smooth path [m]."""
        begin = bisect_left(self._t, end - NOISE_SPAN - ROUNDED)
        asides = sorted(self._aside[max(begin - 1, 0) :])
        return asides[(len(asides) - 1) // 4] / QUARTILE if asides else PRIOR_NOISE

    def _off_the_path(self) -> float:
        """How far the last position but one lies off the line between its neighbours [m].

        In units that make it a sample of the positions' noise (Gasser, Sroka & Jennen-Steinmetz
        1986); a walk does not bend in a thirtieth of a second.
        """
        t0, t1, t2 = self._t[-3:]
        x0, x1, x2 = self._x[-3:]
        y0, y1, y2 = self._y[-3:]
        share = (t1 - t0) / (t2 - t0)
        rest = 1 - share
        aside_x, aside_y = x1 - (rest * x0 + share * x2), y1 - (rest * y0 + share * y2)
        off = math.sqrt(aside_x * aside_x + aside_y * aside_y)
        return off / math.sqrt(1 + share * share + rest * rest)


def _ends_of_lines(
    t: Sequence[float], x: Sequence[float], y: Sequence[float], end: float, period: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Robust lines through x(t) and y(t): where they are at `end` and where one period before.

    Siegel's repeated medians (1982): right as long as fewer than half of the positions are wild.
    """
    slopes_x: list[list[float]] = [[] for _ in t]  # from each point to the others
    slopes_y: list[list[float]] = [[] for _ in t]
    points = zip(t, x, y, slopes_x, slopes_y, strict=True)
    for (r, a, b, from_a, from_b), (s, c, d, from_c, from_d) in combinations(points, 2):
        span = s - r
        slope = (c - a) / span
        from_a.append(slope)
        from_c.append(slope)
        slope = (d - b) / span
        from_b.append(slope)
        from_d.append(slope)
    vx = _middle([_middle(slopes) for slopes in slopes_x])
    vy = _middle([_middle(slopes) for slopes in slopes_y])
    now_x = _middle([a + vx * (end - r) for r, a in zip(t, x, strict=True)])
    now_y = _middle([b + vy * (end - r) for r, b in zip(t, y, strict=True)])
    return (now_x, now_y), (now_x - vx * period, now_y - vy * period)


def _middle(values: list[float]) -> float:
    """The median of known values, at least one."""
    values.sort()
    count = len(values)
    return (values[(count - 1) // 2] + values[count // 2]) / 2


def median(values: Sequence[float]) -> float:
    """The median of what is not NaN, NaN where nothing is."""
    known = [value for value in values if value == value]  # NaN is unequal to itself
    return _middle(known) if known else math.nan
