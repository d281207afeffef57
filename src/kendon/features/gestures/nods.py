"""Nods and head tosses: evidence from the head's pitch, and from how the face bobs with it.

A nod is small and quick, and mostly one of several; a toss goes up above where the head is held,
and comes back at once. Both are told once the head is back, and not where it turns aside
meanwhile: who looks at something else and back does neither.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from kendon.features.gestures.beats import (
    LEAST_STEPS,
    NO_BEAT,
    NOD,
    SMOOTH,
    TOSS,
    Beat,
    Course,
    Kind,
    beat,
    too_far,
)
from kendon.features.gestures.evidence import Weighing
from kendon.features.gestures.series import ROUNDED, Series

#: What goes farther down is a dip, no nod; but who has looked to the ground comes farther up for a
#: toss than the toss is high [rad].
LOWEST_NOD, HIGHEST_TOSS = math.radians(24), math.radians(45)
#: A beat turns so long after it began, and is over so long after that [s].
HALF_BEAT = 0.35
#: A beat is told for so long after it, and fades within so long [s].
TOLD, FADES = 0.3, 0.3
#: What is slower than a nod is the mean over so long; what is left of it is looked at over so long
#: [s].
SLOW, NODS = 0.3, 0.45
#: The middle of nine normal values lies so many standard deviations from the least of them, and
#: what is before and behind it about as many the other way.
EXTREMES = 2.0


class TossEvidence(NamedTuple):
    """What speaks for a toss."""

    beat: float
    bob: float
    straight: float


class NodEvidence(NamedTuple):
    """What speaks for a nod."""

    beat: float
    bob: float
    straight: float
    quick: float


NODDED = Weighing(math.radians(5.0), math.radians(0.6), -5.0, 8.0)  # down and back [rad]
TOSSED = Weighing(math.radians(5.0), math.radians(0.45), -5.0, 8.0)  # up and back [rad]
# Where the head is told by the middle of the skull it hardly bobs, however it nods.
BOB = Weighing(0.008, 0.003, 0.0, 5.0)  # of the face over the shoulders, likewise [m]
STRAIGHT = Weighing(math.radians(11), math.radians(-1.2), -6.0, 1.5)  # turned meanwhile [rad]
QUICK = Weighing(math.radians(3.0), math.radians(0.5), -4.0, 4.0)  # from top to bottom [rad]


class Moves(NamedTuple):
    """What the head does over the latest seconds, until an instant."""

    end: float  # [s]
    pitch: Series  # [rad], down is positive
    course: Course  # of the pitch
    noise: float  # of the pitch [rad]
    level: float  # how the head is usually held; NaN when unknown [rad]
    yaw: Series  # [rad]
    sinking: Course  # of the face's height over the shoulders, down is positive [m]


def nod_evidence(moves: Moves) -> tuple[NodEvidence, TossEvidence]:
    """What speaks for a nod and for a toss."""
    steps = moves.course.steps
    # Who has looked down and looks up again does not toss the head back.
    level = moves.level if moves.level == moves.level else math.inf
    far = too_far(steps, LOWEST_NOD, HIGHEST_TOSS)
    nod = NO_BEAT if far else beat(steps, NOD)
    toss = NO_BEAT if far else beat(steps, TOSS, level)
    return (
        NodEvidence(
            _told(NODDED, nod, moves.course),
            _bob(moves, NOD),
            _straight(moves, nod),
            _quick(moves),
        ),
        TossEvidence(_told(TOSSED, toss, moves.course), _bob(moves, TOSS), _straight(moves, toss)),
    )


def _told(weighing: Weighing, found: Beat, course: Course) -> float:
    """The evidence of a beat, which is told once: it counts for a while after, and then no more.

    NaN when unknown.
    """
    favour = weighing.evidence(found.size - EXTREMES * course.error, course.error)
    if not favour > 0.0:
        return favour  # NaN stays NaN
    return favour * min(1.0, max(0.0, 1.0 - (found.over * SMOOTH - TOLD) / FADES))


def _bob(moves: Moves, kind: Kind) -> float:
    """The evidence that the face goes down or up and back; NaN when unknown."""
    return _told(BOB, beat(moves.sinking.steps, kind), moves.sinking)


def _straight(moves: Moves, found: Beat) -> float:
    """The evidence that the head does not turn aside meanwhile; NaN when unknown."""
    turn = moves.end - found.ago * SMOOTH
    return STRAIGHT.evidence(moves.yaw.range(turn - HALF_BEAT, turn + HALF_BEAT), 2.0 * moves.noise)


def _quick(moves: Moves) -> float:
    """The evidence that the head goes up and down quickly, in nods too quick for steps.

    What is left of the pitch without its mean over a while: of a sine, half its height squared is
    twice its variance. NaN when unknown.
    """
    first = moves.pitch.first(moves.end - NODS - SLOW)
    t, values = moves.pitch.t[first:], moves.pitch.values[first:]
    squares = []
    behind = ahead = 0
    window = 0.0
    for at, value in zip(t, values, strict=True):
        if at > t[-1] - SLOW / 2 + ROUNDED:
            break  # what comes after is not known yet
        while ahead < len(t) and t[ahead] <= at + SLOW / 2 + ROUNDED:
            window += values[ahead]
            ahead += 1
        while t[behind] < at - SLOW / 2 - ROUNDED:
            window -= values[behind]
            behind += 1
        if at >= moves.end - NODS - SLOW / 2 - ROUNDED:
            squares.append((value - window / (ahead - behind)) ** 2)
    count = len(squares)
    if count < LEAST_STEPS:
        return math.nan
    by_chance = moves.noise * moves.noise * (1.0 + EXTREMES * math.sqrt(2.0 / count))
    variance = max(0.0, sum(squares) / count - by_chance)
    return QUICK.evidence(math.sqrt(8.0 * variance), moves.noise)
