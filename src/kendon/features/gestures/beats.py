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
#: What goes so many times as far one way as the other is no beat, but a start or an end of
#: something larger.
ONE_WAY = 3.0
#: Standard error of a median over that of the mean, for normal noise.
INEFFICIENCY = 1.25


class Kind(NamedTuple):
    """A kind of beat, in steps: what takes longer is something else."""

    sign: float  # 1 = down, -1 = up
    there: int  # it turns so soon after it began
    back: int  # and is back so soon after that
    away: int  # so long it is more than half of the way there


#: The head is held back for a moment in a toss; who looks up, looks up for longer.
NOD, TOSS = Kind(1.0, 3, 3, 3), Kind(-1.0, 5, 8, 6)


class Course(NamedTuple):
    """How something went over the latest time of a beat."""

    steps: Sequence[float]  # medians of `SMOOTH`; empty where too few are known
    error: float  # the standard error of one


def course_of(series: Series, end: float, noise: float) -> Course:
    """Values step by step; where there are none it goes on in a straight line to the next.

    Of a source that is slow, or loses the person for a moment, a step still takes its time.

    Args:
        series: of the values.
        end: of the last step [s].
        noise: of a single value.
    """
    first, values = series.first(end - LASTS - SMOOTH), series.values
    seen = max(1, len(values) - first)
    middles: list[float] = []
    known = missing = 0
    for k in range(round(LASTS / SMOOTH), -1, -1):
        last = series.first(end - k * SMOOTH) if k else len(values)
        if last > first:
            step = sorted(values[first:last])
            middle = (last - first) // 2
            value = 0.5 * (step[middle] + step[-1 - middle])
            if middles:
                rise = (value - middles[-1]) / (missing + 1)
                middles += [middles[-1] + rise * (i + 1) for i in range(missing)]
            middles.append(value)
            known, missing = known + 1, 0
        else:
            missing += 1
        first = last
    if middles:
        middles += [middles[-1]] * missing
    # Of a source slower than a beat there are no steps, nor what they would be made of.
    error = INEFFICIENCY * noise * math.sqrt(known / seen)
    return Course(middles if known >= LEAST_STEPS else [], error)


class Beat(NamedTuple):
    """The largest beat of its kind in a course."""

    size: float  # how far it goes one way and comes back, the lesser of both; NaN when unknown
    ago: int  # how many steps ago it turned
    over: int  # how many steps ago it was back


#: There is none.
NO_BEAT = Beat(0.0, 0, 0)


def beat(steps: Sequence[float], kind: Kind, level: float = math.inf) -> Beat:
    """The largest beat of a kind; `NO_BEAT` where there is none.

    Args:
        steps: what is positive is down.
        kind: of beat.
        level: what goes up counts only so far as it goes above this.

    >>> beat([0.0, 0.0, 5.0, 8.0, 2.0, 1.0], NOD)
    Beat(size=7.0, ago=2, over=0)
    >>> beat([0.0, 0.0, 5.0, 8.0, 2.0, 1.0], TOSS)
    Beat(size=0.0, ago=0, over=0)
    """
    if len(steps) < LEAST_STEPS:
        return Beat(math.nan, 0, 0)
    best = NO_BEAT
    way = [kind.sign * step for step in steps]
    least = -level if kind.sign < 0 else -math.inf
    for k in range(1, len(way) - 1):
        behind = way[k + 1 : k + 1 + kind.back]
        size = min(
            way[k] - min(way[max(0, k - kind.there) : k]), way[k] - min(behind), way[k] - least
        )
        if size > best.size and _away(way, k, way[k] - size / 2) <= kind.away:
            # It is back where what it went there is made up for.
            over = next(i for i, step in enumerate(behind) if way[k] - step >= size)
            best = Beat(size, len(way) - 1 - k, len(way) - 2 - k - over)
    return best


def _away(way: Sequence[float], k: int, half: float) -> int:
    """For how many steps around one it stays above half of the way."""
    first = last = k
    while first > 0 and way[first - 1] > half:
        first -= 1
    while last < len(way) - 1 and way[last + 1] > half:
        last += 1
    return last - first + 1


def too_far(steps: Sequence[float], lowest: float, highest: float) -> bool:
    """Whether a course goes down or up and back by too much for a beat, which hides any in it.

    >>> too_far([0.0, 0.0, 5.0, 8.0, 2.0, 1.0], 6.0, 6.0)
    True
    """
    for sign, largest in ((1.0, lowest), (-1.0, highest)):
        way = [sign * step for step in steps]
        for k in range(1, len(way) - 1):
            there, back = way[k] - min(way[:k]), way[k] - min(way[k + 1 :])
            if min(max(there, back), ONE_WAY * min(there, back)) > largest:
                return True
    return False
