"""Head dips: evidence from where the face points; and what a head does, for nods and tosses.

The pitch is taken from the person's own recent way of holding the head, since cameras are
mounted askew and people look at the ground while they walk. A dip goes down by more than twenty
degrees within a third of a second and comes up within a second; the neck bends, not the trunk. Who
looks down at something takes longer, stays there, and mostly turns the head meanwhile. A bow is
none: there the trunk takes the head along.

A head that bends takes the face down with it, by centimetres over the shoulders: that is seen
from afar, too, where nobody can tell any more where a face points.

A head whose pitch is noisy is looked at for longer.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from kendon.features.gestures.beats import INEFFICIENCY, SMOOTH, Course, course_of
from kendon.features.gestures.evidence import Weighing
from kendon.features.gestures.nods import EXTREMES, Moves, NodEvidence, TossEvidence, nod_evidence
from kendon.features.gestures.series import Series, quantile
from kendon.geometry import Quaternion, Vec3, wrap_angle

#: The pitch now is the median of so long [s], and of so much longer the noisier it is.
NOW, LONGER = 0.1, 0.25
#: At this noise it is the longest [rad].
NOISY = math.radians(10)
#: A head is held as it was in the median from this long ago until this long ago [s].
HELD_FROM, HELD_UNTIL = 2.4, 0.4
#: So much must be known for that [s].
HELD_LEAST = 0.8
#: How uncertain it is otherwise how somebody holds the head [rad].
UNSURE = math.radians(12)
#: How unsure shoulders are is told by so long [s].
UNREST = 2.0
#: Whom somebody faces is told by the median of so long [s].
FACING = 0.4
#: A dip goes down within so long [s].
FALLS = 0.8
#: Who has come so much of the way up again dips no more; who has come half of that, still does.
UP_AGAIN = 0.8
#: How noisy the pitch and the face's height are is told by so long: a beat is soon over, but what
#: is seen of it by a slow camera looks like noise as long as it lasts [s].
QUIET = 3.0
#: So many times as long a dip takes to go down, or most of it.
STEPS_DOWN = 2
#: And to take the face down, whose height changes more slowly at first.
STEPS_SINKING = 3
#: The face is so far from the middle of the neck, about which the head bends [m]: 0.07 of the
#: stature (Winter 2009).
LEVER = 0.12
#: A trunk may bend by so much in walking; what is more it takes from the head's pitch [rad].
WALKING = math.radians(6)
#: Who bows bends the neck, too: the pitch changes by so many times as much.
NECK = 1.5
#: The noise that is assumed while there are too few frames to estimate it, of the pitch [rad] and
#: of the face's height [m].
PRIOR_NOISE, PRIOR_UNREST = math.radians(5), 0.01


class DipEvidence(NamedTuple):
    """What speaks for a head dip."""

    down: float
    floor: float
    turned: float
    brief: float
    onset: float
    sunk: float
    sank: float

    @property
    def of_pitch(self) -> tuple[float, ...]:
        """What of it is told by where the face points, not by where it is."""
        return self[:-2]


DOWN = Weighing(math.radians(15), math.radians(3.0), -4.0, 5.0)  # from the usual [rad]
FLOOR = Weighing(math.radians(18), math.radians(5.0), -2.0, 2.0)  # from the horizontal [rad]
TURNED = Weighing(math.radians(15), math.radians(-6.0), -2.0, 0.5)  # within half a second [rad]
BRIEF = Weighing(math.radians(12), math.radians(-4.0), -3.0, 1.0)  # down a second ago [rad]
ONSET = Weighing(math.radians(14), math.radians(3.0), -3.0, 3.0)  # steepest in 0.2 s [rad]
# Where the head is told by the middle of the skull it hardly sinks, however it bends.
SUNK = Weighing(0.028, 0.006, -1.0, 6.0)  # of the face over the shoulders, from the usual [m]
SANK = Weighing(0.026, 0.006, -1.0, 6.0)  # the same in 0.3 s, at its fastest [m]


class Head:
    """Where the face points over the latest seconds."""

    def __init__(self) -> None:
        self._pitch = Series()  # [rad], down is positive
        self._yaw = Series()  # [rad], from the way to the robot
        self._over = Series()  # [m], the face's height over the shoulders
        self._breadth = Series()  # [m], from shoulder to shoulder

    def clear(self) -> None:
        """Forget everything."""
        for series in (self._pitch, self._yaw, self._over, self._breadth):
            series.clear()

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

    def add_shoulders(self, t: float, head: Vec3, left: Vec3, right: Vec3) -> None:
        """Take in the face and the shoulders at an instant [m]; NaN when unknown."""
        x, y, z = left[0] - right[0], left[1] - right[1], left[2] - right[2]
        self._over.add(t, head[2] - 0.5 * (left[2] + right[2]))
        self._breadth.add(t, math.sqrt(x * x + y * y + z * z))

    def seen(self, since: float) -> bool:
        """Whether the head has been seen from an instant on."""
        return self._pitch.seen(since) or self._over.seen(since)

    def aside(self, end: float, since: float) -> float:
        """How far from the robot the face is turned [rad]; NaN when unknown."""
        return turned(self._yaw, end, since)

    def evidence(
        self, end: float, since: float, flexion: float
    ) -> tuple[DipEvidence, NodEvidence | None, TossEvidence | None]:
        """What the head does in an interval in which it is seen.

        Args:
            end: of the interval [s].
            since: its first frame [s].
            flexion: how far the trunk is bent forward from its usual way; NaN when unknown [rad].

        Returns:
            No evidence of a nod or toss where nobody can tell where the face points.
        """
        taken_along = NECK * (flexion - WALKING) if flexion > WALKING else 0.0
        unrest = self._unrest(end)
        heights = course_of(self._over, end, unrest)
        sinking = Course([-height for height in heights.steps], heights.error)
        sunk = self._sunk(end, since, sinking.steps, unrest, LEVER * math.sin(taken_along))
        if not self._pitch.seen(since):
            return DipEvidence(math.nan, math.nan, math.nan, math.nan, math.nan, *sunk), None, None
        jitter = self._pitch.jitter(end - QUIET)
        noise = jitter if jitter == jitter else PRIOR_NOISE
        begin = end - NOW - LONGER * min(1.0, noise / NOISY)
        pitches = self._pitch.since(begin) or self._pitch.since(since)
        noise_now = INEFFICIENCY * noise / math.sqrt(len(pitches))
        level = self._pitch.usual(end - HELD_FROM, end - HELD_UNTIL, HELD_LEAST)
        usual, unsure = level, noise_now
        if usual != usual:
            usual, unsure = 0.0, math.hypot(noise_now, UNSURE)
        pitch = quantile(pitches, 0.5)
        # A second ago, a dip had hardly begun.
        before = quantile(self._pitch.between(end - 1.2, end - 0.8), 0.5)
        yaws = self._yaw.since(begin) or self._yaw.since(since)
        turn = quantile(yaws, 0.5) - quantile(self._yaw.between(end - 0.7, end - 0.4), 0.5)
        course = course_of(self._pitch, end, noise)
        # Noise alone turns a head by so much.
        unsure_turn = math.sqrt(2.0) * noise_now
        dip = DipEvidence(
            DOWN.evidence(pitch - usual - taken_along, unsure),
            FLOOR.evidence(pitch - taken_along, noise_now),
            TURNED.evidence(_above(abs(turn) - unsure_turn), unsure_turn),
            BRIEF.evidence(before - usual, unsure),
            _while_down(
                ONSET.evidence(
                    _steepest(course.steps, STEPS_DOWN) - taken_along - EXTREMES * course.error,
                    math.sqrt(2.0) * course.error,
                ),
                course.steps,
                course.error,
            ),
            *sunk,
        )
        return dip, *nod_evidence(Moves(end, self._pitch, course, noise, level, self._yaw, sinking))

    def _unrest(self, end: float) -> float:
        """The noise of the face's height over the shoulders, from frame to frame [m]."""
        jitter = self._over.jitter(end - QUIET)
        return jitter if jitter == jitter else PRIOR_UNREST

    def _sunk(
        self, end: float, since: float, sinking: Sequence[float], noise: float, along: float
    ) -> tuple[float, float]:
        """The evidence that the face sinks, and is sunk; NaN when unknown.

        Args:
            end: of the interval [s].
            since: its first frame [s].
            sinking: steps of its height over the shoulders, downward [m].
            noise: of that, from frame to frame [m].
            along: how far the trunk takes it [m].
        """
        if not self._over.seen(since):
            return math.nan, math.nan
        heights = self._over.since(min(end - NOW, since))
        # What changes in the breadth of the shoulders is the noise of two joints, which no mean
        # takes away where it lasts; half as much is that of the middle between them.
        noise = max(
            noise * INEFFICIENCY / math.sqrt(len(heights)), 0.5 * self._breadth.wander(end - UNREST)
        )
        usual = self._over.usual(end - HELD_FROM, end - HELD_UNTIL, HELD_LEAST)
        sank = _steepest(sinking, STEPS_SINKING)
        return (
            SUNK.evidence(usual - quantile(heights, 0.5) - along, noise),
            _while_down(
                SANK.evidence(sank - along - noise, math.sqrt(2.0) * noise), sinking, noise
            ),
        )


def _latest(course: Sequence[float]) -> Sequence[float]:
    """The steps within which a dip goes down."""
    return course[-round(FALLS / SMOOTH) - 1 :]


def _steepest(course: Sequence[float], apart: int) -> float:
    """How far it goes at most within so many of the latest steps; NaN when unknown."""
    latest = _latest(course)
    return max((b - a for a, b in zip(latest, latest[apart:], strict=False)), default=math.nan)


def _while_down(favour: float, course: Sequence[float], noise: float) -> float:
    """That it went down speaks for a dip until it has come most of the way up again.

    Args:
        favour: the evidence that it went down; NaN when unknown.
        course: steps; what is positive is down.
        noise: their standard error.
    """
    if not favour > 0.0:
        return favour  # NaN stays NaN
    latest = _latest(course)
    way = max(latest) - min(latest)
    back = max(latest) - latest[-1] - EXTREMES * noise
    if not back > 0.0:
        return favour
    return favour * min(1.0, max(0.0, 2.0 * (1.0 - back / way / UP_AGAIN)))


def _above(value: float) -> float:
    """What is above zero of a value that may be unknown."""
    return 0.0 if value < 0.0 else value  # NaN stays NaN


def turned(yaw: Series, end: float, since: float) -> float:
    """How far from the robot a head or a chest is turned in an interval [rad]; NaN when unknown."""
    # Not the other way round: the middle between backward to the left and to the right is ahead.
    return quantile([abs(one) for one in yaw.since(min(end - FACING, since))], 0.5)
