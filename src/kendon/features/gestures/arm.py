"""Where an arm's hand has been over the latest seconds.

An arm is described by where the wrist is from its shoulder: how high, how far toward the robot
and how far across, and by how upright the forearm is. All of it is relative to the person, so
that neither the robot's motion nor a walk is taken for a gesture.

Lengths are in units of the arm, shoulder to wrist. How sure the joints are is told by the bones:
their lengths do not change, so what changes in them is the noise of the joints.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from operator import sub
from typing import NamedTuple

from kendon.features.gestures.series import ROUNDED, change, quantile
from kendon.geometry import UNKNOWN_POINT, Vec3

#: The arm from shoulder to wrist, of a person 1.7 m tall: 0.332 of the stature (Winter 2009) [m].
ARM = 0.56
#: The shortest and longest arms there are, from a small child to a very tall adult [m].
SHORTEST, LONGEST = 0.3, 0.8
#: The shoulder is lower than the middle of the face: 0.085 of that stature (Winter 2009) [m].
FACE_OVER_SHOULDER = 0.145

#: Where the hand is is told by the median of so long [s], and of so much longer the less sure the
#: joints are.
NOW, LONGER = 0.1, 0.15
#: When bones seem to change by so much, it is the longest [standard dev., arms].
UNSURE = 0.03
#: From tenth to tenth of normal values [standard dev.].
TENTHS = 2.56
#: How fast it goes is told by so long [s].
JUST = 0.2
#: A speed is so many times as noisy as a place: two medians of three frames each, a tenth of a
#: second apart [1/s].
OF_SPEED = 10.0
#: A hand is held where it has been for so long, about as long as an arm swing is up [s]. The
#: turning points of a wave are nearer to each other.
HOLD = 0.5
#: A hand that lasts there stays longer than any arm swing [s].
LAST = 0.8
#: How high the other hand came is asked of so long: more than a stride [s].
STRIDE = 1.2
#: Hands are up, or out, from here on [arms over the shoulder, arms before it].
RAISED, OUT = -0.5, 0.4
#: Lower than this a hand hangs [arms over the shoulder].
HANGS = -0.65
#: No farther out than this a hand is beside the trunk, or behind it [arms before the shoulder].
BEHIND = 0.2
#: So low every hand hangs [m over the shoulder]; of it no more is asked.
HANGING = HANGS * LONGEST
#: Who lifts both hands keeps them this near to where they were highest [arms].
TOGETHER = 0.15
#: The period of the slowest cameras; gaps up to half as much again are theirs [s].
SLOWEST = 0.2
GAP = 1.5 * SLOWEST
#: How far a hand usually comes is asked of so long before the last `LAST`: a stride [s].
USUAL = 1.0
#: No hand gestures faster [m/s], nor is it misplaced by more from frame to frame [m]: what goes
#: farther at once is not the hand, or was not. Where the other shoulder stands in for a lost one,
#: that moves all hands by a shoulder's breadth.
FASTEST, MISPLACED = 6.0, 0.30
#: A hand that has leapt is believed in where it stays for so many frames; single ones are taken
#: for something else.
BELIEVED = 3
#: So long a row is kept [s]; it is let go of when twice as old.
KEPT = LAST + USUAL


class Row(NamedTuple):
    """One frame [m]; NaN where it is not known, or not asked of a hand that hangs."""

    up: float  # the wrist, over the shoulder
    toward: float  # before it, toward the robot
    across: float
    forearm: float  # sine of its elevation, -1 of a hand that hangs
    bones: float  # the length of both bones together
    apart: float  # wrist from the face, as seen from the robot
    opened: float  # wrist from the shoulder
    parted: float  # wrist from the other wrist


#: Their places in a row.
UP, TOWARD, ACROSS, BONES = map(Row._fields.index, ("up", "toward", "across", "bones"))


class Lately(NamedTuple):
    """What a hand did over the last `LAST` seconds, and where it is now."""

    columns: tuple[tuple[float, ...], ...]  # the values of each field of a `Row`
    held: int  # from this place on is the last `HOLD`
    now: int  # and from this one on, now
    since: float  # when that is [s]
    up: float  # where the hand is now [arms over the shoulder]
    toward: float  # and how far before it [arms]
    seen: float  # share of the while in which the hand was seen
    noise: float  # of a place, standard dev. [arms]
    noise_now: float  # of a median of places now
    raised: bool  # whether the hand did anything but hang ...
    out: bool  # ... or was before the trunk


class Arm:
    """One arm over the latest seconds.

    Attributes:
        first: from when on the hand has been seen [s].
        low: when it was last down [s].
        back: when it was last not out [s].
    """

    def __init__(self) -> None:
        self._t: list[float] = []  # [s]
        self._rows: list[Row] = []
        self._place = UNKNOWN_POINT  # of the wrist from its shoulder [m], in the last row kept
        self._leapt: list[tuple[float, Vec3, Row]] = []  # rows that are not believed yet
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._asked = -math.inf  # [s], the end of the last interval asked about
        self._t.clear()
        self._rows.clear()
        self._leapt.clear()
        self.first = -math.inf
        self.low = self.back = math.inf

    def add(
        self, t: float, shoulder: Vec3, elbow: Vec3, wrist: Vec3, head: Vec3, other: Vec3,
        *, own: bool = True,
    ) -> None:  # fmt: skip
        """Take in the joints, the face and the other wrist at an instant; NaN when unknown.

        Args:
            t: later than the last [s].
            shoulder: the own one, or what stands in for it (`shoulder_of`) [m].
            elbow: of this arm [m].
            wrist: of this arm [m].
            head: the face [m].
            other: the other wrist [m].
            own: whether the shoulder is the own one: only then are bones measured.
        """
        sx, sy, sz = shoulder
        wx, wy, wz = wrist
        up = wz - sz
        if not math.isfinite(up):  # nothing is known of this hand
            return
        ex, ey, ez = elbow
        hx, hy, hz = head
        ox, oy, oz = other
        dx, dy = wx - sx, wy - sy
        ax, ay, az = wx - ex, wy - ey, wz - ez
        bx, by, bz = ex - sx, ey - sy, ez - sz
        way = math.sqrt(sx * sx + sy * sy) or math.nan
        lower = math.sqrt(ax * ax + ay * ay + az * az) or math.nan
        toward, across = -(dx * sx + dy * sy) / way, (dx * sy - dy * sx) / way
        bones = lower + math.sqrt(bx * bx + by * by + bz * bz) if own else math.nan
        if up < HANGING:
            row = Row(up, toward, across, -1.0, bones, math.nan, math.nan, math.nan)
        else:
            beside, above = ((wx - hx) * sy - (wy - hy) * sx) / way, wz - hz
            ox, oy, oz = ox - wx, oy - wy, oz - wz
            row = Row(
                up,
                toward,
                across,
                az / lower,
                bones,
                math.sqrt(beside * beside + above * above),
                math.sqrt(dx * dx + dy * dy + up * up),
                math.sqrt(ox * ox + oy * oy + oz * oz),
            )
        self._take(t, (dx, dy, up), row)

    def _take(self, t: float, place: Vec3, row: Row) -> None:
        """Keep a row.

        Rows after a leap wait until the hand has stayed there for `BELIEVED` frames; then all that
        was before is dropped.
        """
        stamps, leapt = self._t, self._leapt
        last = leapt[-1][0] if leapt else stamps[-1] if stamps else t
        if stamps and leaps(self._place, place, t - last):
            if leapt and leaps(leapt[-1][1], place, t - last):
                leapt.clear()
            leapt.append((t, place, row))
            if len(leapt) < BELIEVED:
                return
            stamps[:], self._rows[:] = [one[0] for one in leapt], [one[2] for one in leapt]
        else:
            if stamps and t - stamps[0] > 2 * KEPT:
                old = bisect_left(stamps, t - KEPT)
                del stamps[:old], self._rows[:old]
            stamps.append(t)
            self._rows.append(row)
        leapt.clear()
        self._place = place

    def length(self, begin: float) -> float:
        """Of upper and lower arm together, from an instant on [m]; NaN when unknown."""
        whole = quantile([row.bones for row in self.since(begin)], 0.5)
        return whole if SHORTEST <= whole <= LONGEST else math.nan

    def lately(self, end: float, since: float, arm: float) -> Lately:
        """The latest rows, of a hand that is seen in an interval; asked of intervals in order.

        Keeps in mind when the hand was last down and last not out.

        Args:
            end: of the interval [s].
            since: its first frame [s].
            arm: the arms' length [m].
        """
        stamps = self._t
        first = bisect_left(stamps, min(end - LAST, since) - ROUNDED)
        columns = tuple(zip(*self._rows[first:], strict=True))
        ups, towards, bones = columns[UP], columns[TOWARD], columns[BONES]
        raised, out = max(ups) > HANGS * arm, max(towards) > BEHIND * arm
        noise = unsure = 0.0
        if raised or out:
            noise = change(bones) / arm
            wander = (quantile(bones, 0.9) - quantile(bones, 0.1)) / TENTHS / arm
            # Where the elbow is not known nobody can tell, and looks for the longest.
            unsure = min(1.0, max(noise, wander) / UNSURE) if wander == wander else 1.0
        now_since = min(end - NOW - LONGER * unsure, stamps[-1])
        now = bisect_left(stamps, now_since - ROUNDED, first) - first
        up, toward = quantile(ups[now:], 0.5) / arm, quantile(towards[now:], 0.5) / arm
        self._watch(stamps[first], end, up, toward)
        return Lately(
            columns,
            bisect_left(stamps, end - HOLD - ROUNDED, first) - first,
            now,
            now_since,
            up,
            toward,
            self._coverage(first, end, LAST),
            noise,
            noise / math.sqrt(len(ups) - now),
            raised,
            out,
        )

    def since(self, begin: float) -> list[Row]:
        """The rows from an instant on [s]."""
        return self._rows[bisect_left(self._t, begin - ROUNDED) :]

    def _watch(self, first: float, end: float, up: float, toward: float) -> None:
        """Keep in mind when the hand was last down and last not out.

        Nothing is known of before it was seen, nor of a while in which nobody asked.
        """
        new = end - first < LAST / 2 or end - self._asked > LAST
        self._asked = end
        if new:
            self.first = first
        if up < RAISED or self.low > end or new:
            self.low = end if up < RAISED else first
        if toward < OUT or self.back > end or new:
            self.back = end if toward < OUT else first

    def seen(self, since: float) -> bool:
        """Whether the hand has been seen from an instant on."""
        return bool(self._t) and self._t[-1] >= since - ROUNDED

    def stirs(self, end: float, arm: float) -> float:
        """How far a hand that does not hang goes within `LAST` beyond its noise [arms]."""
        rows = [row for row in self.since(end - LAST) if row.up > HANGS * arm]
        if len(rows) < 2:
            return 0.0
        columns = tuple(zip(*rows, strict=True))
        farthest = max(quantile(way, 0.9) - quantile(way, 0.1) for way in columns[:3])
        return max(0.0, farthest - TENTHS * change(columns[BONES])) / arm

    def swung(self, begin: float, end: float, arm: float) -> float:
        """How high the hand came within a stride and has left again [arms over the shoulder].

        Returns:
            NaN for a hand that is up still, with the other, and where too little is known.
        """
        if not self._t or end - self._t[0] < STRIDE / 2:
            return math.nan
        highest = quantile([row.up for row in self.since(end - STRIDE)], 0.9) / arm
        now = quantile([row.up for row in self.since(begin)], 0.5) / arm
        return highest if now <= max(highest - TOGETHER, RAISED) else math.nan

    def covered(self, end: float) -> float:
        """Which share of the last stride the hand was seen in, from its first frame there on."""
        first = bisect_left(self._t, end - STRIDE - ROUNDED)
        return self._coverage(first, end, STRIDE) if first < len(self._t) else 0.0

    def seen_for(self, end: float, span: float) -> float:
        """Which share of a while up to `end` has passed since the hand's first frame there."""
        first = bisect_left(self._t, end - span - ROUNDED)
        return min(1.0, (end - self._t[first]) / span) if first < len(self._t) else 0.0

    def _coverage(self, first: int, end: float, span: float) -> float:
        """Which share of a while up to `end` the hand was seen in from a row on.

        All of it but the longest gap, where that is no slow camera's.
        """
        stamps = self._t[first:]
        gap = max(map(sub, stamps[1:], stamps), default=0.0)
        return max(
            0.0, min(1.0, (end - stamps[0]) / span) - (gap / span if gap > GAP + ROUNDED else 0.0)
        )

    def reached(self, end: float, of: int) -> float:
        """How far the hand came, upward or another way, before the last `LAST` seconds [m].

        NaN where less than half a stride of that is known, but for a slow camera's period.
        """
        stamps = self._t
        first = bisect_left(stamps, end - LAST - USUAL - ROUNDED)
        last = bisect_left(stamps, end - LAST - ROUNDED, first)
        if first == last or stamps[last - 1] - stamps[first] < STRIDE / 2 - SLOWEST:
            return math.nan
        return quantile([row[of] for row in self._rows[first:last]], 0.9)

    def speed(self, end: float, of: int) -> float:
        """How fast the hand goes just now, upward or another way [m/s]; NaN when unknown.

        From the middle of one half of the while to that of the other: single wild values are
        passed over.
        """
        stamps = self._t
        first = bisect_left(stamps, end - JUST - ROUNDED)
        half = bisect_left(stamps, end - JUST / 2 - ROUNDED, first)
        if first == half or half == len(stamps):
            return math.nan
        before = quantile([row[of] for row in self._rows[first:half]], 0.5)
        after = quantile([row[of] for row in self._rows[half:]], 0.5)
        early, late = stamps[first:half], stamps[half:]
        return (after - before) / (sum(late) / len(late) - sum(early) / len(early))


def leaps(before: Vec3, now: Vec3, seconds: float) -> bool:
    """Whether a hand is farther from where it was [m] than it can have gone in so long [s]."""
    x, y, z = now[0] - before[0], now[1] - before[1], now[2] - before[2]
    most = MISPLACED + FASTEST * seconds
    return x * x + y * y + z * z > most * most


def shoulder_of(own: Vec3, other: Vec3, head: Vec3) -> Vec3:
    """A shoulder, or the best there is in its place: the other one, or below the face [m]."""
    if own[2] == own[2]:
        return own
    if other[2] == other[2]:
        return other
    x, y, z = head
    return (x, y, z - FACE_OVER_SHOULDER) if z == z else UNKNOWN_POINT
