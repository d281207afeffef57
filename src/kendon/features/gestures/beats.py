"""Beats: something small that goes one way and at once comes back, once or again and again.

A nod is a beat of the head's pitch, a toss another; the face bobs with both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from kendon.features.gestures.series import Series

#: A beat is smoothed over so long: a third of a quick nod [s].
SMOOTH = 0.1
#: The longest, a toss that is held for a moment, is over in so long [s].
LASTS = 1.1
#: From so many steps on there may be a beat.
LEAST_STEPS = 4
#: What goes down is over its lowest point so soon after it began, and back so soon after that; a
#: toss takes longer, as the head is held back for a moment [steps].
DOWN, DOWN_BACK = 3, 3
UP, UP_BACK = 5, 8
#: What goes so many times as far one way as the other is no beat, but a start or an end of
#: something larger.
ONE_WAY = 3.0


def steps(series: Series, end: float) -> list[float]:
    """Medians of the time of a beat, step by step of `SMOOTH`; none where too few are known."""
    first, values = series.first(end - LASTS - SMOOTH), series.values
    middles = []
    for k in range(round(LASTS / SMOOTH), -1, -1):
        last = series.first(end - k * SMOOTH) if k else len(values)
        if last > first:
            step = sorted(values[first:last])
            middle = (last - first) // 2
            middles.append(0.5 * (step[middle] + step[-1 - middle]))
        first = last
    return middles if len(middles) >= LEAST_STEPS else []


class Beat(NamedTuple):
    """The largest beat of a course."""

    size: float  # how far it goes one way and comes back, the lesser of both; NaN when unknown
    ago: int  # how many steps ago it turned
    over: int  # how many steps ago it was back


def beat(course: Sequence[float], lowest: float = math.inf, highest: float = math.inf) -> Beat:
    """The largest beat of a course; of size 0 where there is none.

    Args:
        course: steps; what is positive is down.
        lowest: what goes farther down is no beat, and hides those beside it.
        highest: nor is what goes farther up.

    >>> beat([0.0, 0.0, 5.0, 8.0, 2.0, 1.0])
    Beat(size=7.0, ago=2, over=0)
    >>> beat([0.0, 0.0, 5.0, 8.0, 2.0, 1.0], lowest=6.0)
    Beat(size=0.0, ago=0, over=0)
    """
    if len(course) < LEAST_STEPS:
        return Beat(math.nan, 0, 0)
    best = Beat(0.0, 0, 0)
    for sign, before, after, largest in (
        (1.0, DOWN, DOWN_BACK, lowest), (-1.0, UP, UP_BACK, highest)
    ):  # fmt: skip
        way = [sign * step for step in course]
        for k in range(1, len(way) - 1):
            there = way[k] - min(way[max(0, k - before) : k])
            behind = way[k + 1 : k + 1 + after]
            back = way[k] - min(behind)
            if min(there, back) > best.size:
                # It is back where what it went there is made up for.
                over = next(i for i, step in enumerate(behind) if way[k] - step >= min(there, back))
                best = Beat(min(there, back), len(way) - 1 - k, len(way) - 2 - k - over)
            far_there, far_back = way[k] - min(way[:k]), way[k] - min(way[k + 1 :])
            if min(max(far_there, far_back), ONE_WAY * min(far_there, far_back)) > largest:
                return Beat(0.0, 0, 0)
    return best
