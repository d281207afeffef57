"""Waves and handshakes: evidence from one arm.

An arm is described by where the wrist is from its shoulder: how high, how far toward the robot
and how far across, and by how upright the forearm is. All of it is relative to the person, so
that neither the robot's motion nor a walk is taken for a gesture.

A wave is a hand held up beside the head, forearm upright, mostly swinging to and fro once to
three times a second; at the turning points of a wide one the forearm lies level for a moment.
What looks like it for a moment is the arm swing of a brisk walk: there the hand comes up for less
than half a second, and the other hand has just been as high. A handshake is a hand held out to
the partner between waist and chest, to about halfway, and shaken up and down; an arm that swings
forward in a walk goes back soon.

Who talks holds up hands, too. Those are held together or near the own face and shoulder, or stay
up for long without stirring, which no salutation does.

Lengths are in units of the arm, shoulder to wrist. How sure the joints are is told by the bones:
their lengths do not change, so what changes in them is the noise of the joints.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from operator import sub
from typing import NamedTuple

from kendon.features.gestures.evidence import Weighing, logistic
from kendon.features.gestures.series import ROUNDED, change, quantile, spread, to_and_fro
from kendon.geometry import UNKNOWN_POINT, Vec3

#: The arm from shoulder to wrist, of a person 1.7 m tall: 0.332 of the stature (Winter 2009) [m].
ARM = 0.56
#: The longest and shortest arms there are, from a small child to a very tall adult [m].
SHORTEST, LONGEST = 0.3, 0.8
#: The shoulder is lower than the middle of the face: 0.085 of that stature (Winter 2009) [m].
FACE_OVER_SHOULDER = 0.145

#: Where the hand is is told by the median of so long [s].
NOW = 0.25
#: A hand is held where it has been for so long, about as long as an arm swing is up [s]. The
#: turning points of a wave are nearer to each other.
HOLD = 0.5
#: A hand that lasts there stays longer than any arm swing, most of a stride [s].
LAST = 0.8
#: Swings to and fro are looked for over so long: three strokes of a slow wave [s].
SWINGS = 1.5
#: All but this share of the while a hand must have been up, and all but that one out, to be held
#: there: waves turn, handshakes do not.
LET_GO, DRAWN_BACK = 0.25, 0.15
#: How high the other hand came is asked of so long: more than half a stride [s].
STRIDE = 1.2
#: Hands are up, or out, from here on [arms over the shoulder, arms before it].
RAISED, OUT = -0.5, 0.4
#: Waves turn above this height; a hand that is lower by that much more is on its way down [arms].
TURNS, FALLS = -0.25, 0.2
#: How far noise alone seems to go up and down in that time, in its standard deviations.
FRAYED = 2.0
#: Shorter gaps are a slow camera's [s].
GAP = 0.2
#: Lower than this a hand hangs [arms over the shoulder].
HANGS = -0.65
#: So low every hand hangs [m over the shoulder]; of it no more is asked.
HANGING = HANGS * LONGEST
#: No farther out than this a hand is beside the trunk, or behind it [arms before the shoulder].
BEHIND = 0.2
#: Who lifts both hands keeps them this near to where they were highest [arms].
TOGETHER = 0.15
#: Handshakes are so high [arms over the shoulder].
CHEST = -0.35
#: Two arms' reach and a little lean: nearer than this a salutation is a close one, and how soft
#: that border is [m].
HANDSHAKE_DISTANCE, SOFTNESS = 1.3, 0.12
#: Nearer than this people embrace, and how soft that border is [m].
EMBRACE, EMBRACE_SOFTNESS = 0.75, 0.25
#: So long a row is kept [s]; it is let go of when twice as old.
KEPT = 1.5 * STRIDE


class WaveEvidence(NamedTuple):
    """What speaks for a wave with one hand."""

    height: float
    lasting: float
    upright: float
    sway: float
    alone: float
    opened: float
    parted: float
    fresh: float
    still: float
    faces: float


class HandshakeEvidence(NamedTuple):
    """What speaks for a handshake with one hand."""

    reach: float
    held: float
    halfway: float
    shake: float
    near: float
    level: float
    steady: float
    parted: float
    fresh: float
    faces: float


# Waves.
HEIGHT = Weighing(-0.25, 0.15, -3.0, 2.5)  # of the wrist over the shoulder [arms]
LASTING = Weighing(-0.40, 0.10, -2.0, 2.5)  # the same, where it lasts
UPRIGHT = Weighing(0.30, 0.25, -2.0, 2.0)  # forearm: -1 hangs, 0 horizontal, 1 upright
SWAY = Weighing(0.12, 0.06, -1.0, 3.0)  # to and fro of a hand that is up [arms]
ALONE = Weighing(0.20, 0.08, -4.0, 1.0)  # height over the other hand's highest [arms]
AT_HEAD = Weighing(0.38, -0.08, 0.0, 1.0)  # wrist from the face, as seen from the robot [arms]
OPENED = Weighing(0.33, 0.06, -3.0, 1.0)  # wrist from the shoulder [arms]

# Handshakes.
REACH = Weighing(0.50, 0.10, -3.0, 2.0)  # toward the robot [arms]
HELD_REACH = Weighing(0.40, 0.10, -3.0, 2.0)  # the same, where it is held
HALFWAY = Weighing(0.35, 0.10, -2.0, 1.5)  # share of the way to the robot the hand is out
SHAKE = Weighing(0.06, 0.04, -0.7, 1.5)  # up and down of a hand that is out [arms]
NEAR = Weighing(1.8, -0.2, -7.0, 1.0)  # the person from the robot [m]
STEADY = Weighing(0.08, -0.03, -3.0, 1.0)  # toward the robot and back, standard dev. [arms]
LEVEL = Weighing(0.35, -0.07, -4.0, 0.5)  # higher or lower than `CHEST` [arms]

#: A hand that is held up and does not swing greets from afar, not in a talk.
STILL = Weighing(1.5, 0.1, -5.0, 1.0)  # the person from the robot [m]

# Both.
PARTED = Weighing(0.75, 0.12, -3.0, 1.0)  # wrist from wrist [arms]
FRESH = Weighing(1.8, -0.4, -4.0, 0.5)  # up, or out, without a pause for so long [s]
FACES = Weighing(math.radians(45), math.radians(-15), -3.0, 1.0)  # turned from the robot [rad]

#: One frame's wrist over the shoulder [m], toward the robot and across it [m], sine of the
#: forearm's elevation, length of both bones together [m], wrist from the face, from the shoulder
#: and from the other wrist [m].
_Row = tuple[float, float, float, float, float, float, float, float]
_UP, _ACROSS, _LENGTH, _APART = 0, 2, 4, 5

#: Of a hand that hangs all is said.
NO_WAVE = WaveEvidence(
    HEIGHT.least, LASTING.least, UPRIGHT.least, 0.0, ALONE.least, 0.0, 0.0, 0.0, 0.0, 0.0
)


def _no_handshake(near: float) -> HandshakeEvidence:
    """Of a hand that is not out."""
    return HandshakeEvidence(
        REACH.least, HELD_REACH.least, HALFWAY.least, 0.0, near, 0.0, 0.0, 0.0, 0.0, 0.0
    )


class Arm:
    """One arm over the latest seconds."""

    def __init__(self) -> None:
        self._t: list[float] = []  # [s]
        self._rows: list[_Row] = []
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._t.clear()
        self._rows.clear()
        self._first = -math.inf  # [s], from when on the hand has been seen
        self._low = self._back = math.inf  # [s], when it was last down, and last not out

    def add(
        self, t: float, shoulder: Vec3, elbow: Vec3, wrist: Vec3, head: Vec3, other: Vec3
    ) -> None:
        """Take in the joints, the face and the other wrist at an instant; NaN when unknown."""
        sx, sy, sz = shoulder
        wx, wy, wz = wrist
        up = wz - sz
        if up != up:  # NaN: nothing is known of this hand
            return
        stamps = self._t
        if stamps and t - stamps[0] > 2 * KEPT:
            old = bisect_left(stamps, t - KEPT)
            del stamps[:old], self._rows[:old]
        ex, ey, ez = elbow
        hx, hy, hz = head
        ox, oy, oz = other
        dx, dy = wx - sx, wy - sy
        ax, ay, az = wx - ex, wy - ey, wz - ez
        bx, by, bz = ex - sx, ey - sy, ez - sz
        way = math.sqrt(sx * sx + sy * sy) or math.nan
        lower = math.sqrt(ax * ax + ay * ay + az * az) or math.nan
        stamps.append(t)
        toward, across = -(dx * sx + dy * sy) / way, (dx * sy - dy * sx) / way
        length = lower + math.sqrt(bx * bx + by * by + bz * bz)
        if up < HANGING:
            self._rows.append((up, toward, across, -1.0, length, math.nan, math.nan, math.nan))
            return
        beside, above = ((wx - hx) * sy - (wy - hy) * sx) / way, wz - hz
        ox, oy, oz = ox - wx, oy - wy, oz - wz
        self._rows.append(
            (
                up,
                toward,
                across,
                az / lower,
                length,
                math.sqrt(beside * beside + above * above),
                math.sqrt(dx * dx + dy * dy + up * up),
                math.sqrt(ox * ox + oy * oy + oz * oz),
            )
        )

    def length(self, begin: float) -> float:
        """Of upper and lower arm together, from an instant on [m]; NaN when unknown."""
        whole = quantile([row[_LENGTH] for row in self._since(begin)], 0.5)
        return whole if SHORTEST <= whole <= LONGEST else math.nan

    def evidence(
        self, end: float, since: float, arm: float, other: Arm, distance: float, aside: float
    ) -> tuple[WaveEvidence, HandshakeEvidence]:
        """What this hand does in an interval in which it is seen; asked of intervals in order.

        Args:
            end: of the interval [s].
            since: its first frame [s].
            arm: the arms' length [m].
            other: the other arm.
            distance: of the person from the robot; NaN when unknown [m].
            aside: how far from the robot the person is turned; NaN when unknown [rad].
        """
        stamps = self._t
        first = bisect_left(stamps, min(end - LAST, since) - ROUNDED)
        held_at = bisect_left(stamps, end - HOLD - ROUNDED, first) - first
        now_at = bisect_left(stamps, min(end - NOW, since) - ROUNDED, first) - first
        columns = tuple(zip(*self._rows[first:], strict=True))
        up, toward, _, forearm, length, apart, opened, parted = columns
        up_now, toward_now = quantile(up[now_at:], 0.5) / arm, quantile(toward[now_at:], 0.5) / arm
        self._watch(stamps[first], end, up_now, toward_now)
        near, faces = NEAR.evidence(distance), FACES.evidence(aside)
        up_there, out_there = max(up) > HANGS * arm, max(toward) > BEHIND * arm
        if not (up_there or out_there):
            return NO_WAVE, _no_handshake(near)
        noise = change(length) / arm
        noise_now = noise / math.sqrt(len(up) - now_at)
        frayed = FRAYED * noise  # noise alone goes up and down, too
        parts = PARTED.evidence(quantile(parted[now_at:], 0.5) / arm, noise_now)
        wave, handshake = NO_WAVE, _no_handshake(near)
        if up_there:
            # A hand that turns is as high, and the forearm as upright, as it just was.
            turning = min(1.0, max(0.0, (up_now - TURNS) / FALLS + 1.0))
            height, upright = up_now, quantile(forearm[now_at:], 0.5)
            if turning:
                height += turning * max(0.0, _kept(up[held_at:], 1.0 - LET_GO) / arm - height)
                upright += turning * max(0.0, _kept(forearm[held_at:], 1.0 - LET_GO) - upright)
            # Who has just come into view has not been seen to hold anything.
            share = self._coverage(first, end, LAST)
            lasts = share * LASTING.evidence(_kept(up, LET_GO) / arm, noise_now)
            lasts += (1.0 - share) * LASTING.least
            rows = self._rows[bisect_left(stamps, end - SWINGS - ROUNDED) :]
            rows = [row for row in rows if row[_UP] > TURNS * arm]
            swaying = [row[_ACROSS] for row in rows]
            sway = SWAY.evidence(to_and_fro(swaying) / arm - frayed, frayed)
            # A wave takes the hand to the face and away again. A hand on the head is high, and
            # goes to and fro, for other reasons; so may be one that has just come into view.
            while_up = quantile([row[_APART] for row in rows], 1.0 - LET_GO)
            at_head = min(quantile(apart, 1.0 - LET_GO), while_up) / arm
            on_head = max(0.0, AT_HEAD.evidence(at_head, noise_now))  # 0 when unknown
            free = (1.0 - on_head) * min(1.0, 0.5 + share)
            sway = _freed(sway, free)
            stirs = min(1.0, max(0.0, sway))
            if lasts < 0.0 < sway:
                # A hand that comes and goes is an arm swing, however far it goes aside.
                sway *= 1.0 - lasts / LASTING.least
            alone = other.covered(end) * ALONE.evidence(
                height - other.swung(end - NOW, end, arm), noise_now
            )
            if alone < 0.0 < lasts:
                # A hand that lasts is no arm swing, however high the other one swings.
                alone *= 1.0 - lasts / LASTING.most
            wave = WaveEvidence(
                _freed(HEIGHT.evidence(height, noise_now), free),
                lasts,
                _freed(UPRIGHT.evidence(upright, 2.0 * noise_now), free),
                sway,
                alone,
                OPENED.evidence(quantile(opened[now_at:], 0.5) / arm, noise_now),
                _excused(parts, stirs),
                _excused(self._fresh(self._low, end), stirs),
                (1.0 - stirs) * STILL.evidence(distance),
                faces,
            )
        if out_there:
            share = min(1.0, (end - stamps[first + held_at]) / HOLD) if held_at < len(up) else 0.0
            shaking = [a for a, b in zip(up, toward, strict=True) if b > OUT * arm]
            shake = SHAKE.evidence(to_and_fro(shaking) / arm - frayed, frayed)
            held = share * HELD_REACH.evidence(_kept(toward[held_at:], DRAWN_BACK) / arm, noise_now)
            held += (1.0 - share) * HELD_REACH.least
            if held < 0.0 < shake:
                # Nor is a hand shaken that swings out and back.
                shake *= 1.0 - held / HELD_REACH.least
            # Who embraces somebody brings the hands together.
            embraces = min(1.0, max(0.0, (EMBRACE - distance) / EMBRACE_SOFTNESS))
            handshake = HandshakeEvidence(
                REACH.evidence(toward_now, noise_now),
                held,
                HALFWAY.evidence(toward_now * arm / distance, noise_now),
                shake,
                near,
                LEVEL.evidence(abs(up_now - CHEST), noise_now),
                share * STEADY.evidence(spread(toward[held_at:]) / arm, noise),
                _excused(parts, embraces),
                _excused(self._fresh(self._back, end), shake / SHAKE.most),
                faces,
            )
        return wave, handshake

    def _watch(self, first: float, end: float, up: float, toward: float) -> None:
        """Keep in mind when the hand was last down and last not out; nothing before it is seen."""
        new = end - first < LAST / 2
        if new:
            self._first = first
        if up < RAISED or self._low > end or new:
            self._low = end if up < RAISED else first
        if toward < OUT or self._back > end or new:
            self._back = end if toward < OUT else first

    def _fresh(self, rest: float, end: float) -> float:
        """The evidence of how long a hand has been up, or out.

        Of one that has not been seen at rest nobody knows: it may have been so for longer, and
        nothing speaks for it.

        Args:
            rest: when it was last down, or not out [s].
            end: of the interval [s].
        """
        fresh = FRESH.evidence(end - rest)
        return fresh if rest > self._first else min(0.0, fresh)

    def seen(self, since: float) -> bool:
        """Whether the hand has been seen from an instant on."""
        return bool(self._t) and self._t[-1] >= since - ROUNDED

    def swung(self, begin: float, end: float, arm: float) -> float:
        """How high the hand came within a stride and has left again [arms over the shoulder].

        Returns:
            NaN for a hand that is up still, with the other, and where too little is known.
        """
        if not self._t or end - self._t[0] < STRIDE / 2:
            return math.nan
        highest = quantile([row[_UP] for row in self._since(end - STRIDE)], 0.9) / arm
        now = quantile([row[_UP] for row in self._since(begin)], 0.5) / arm
        return math.nan if now > max(highest - TOGETHER, RAISED) else highest

    def covered(self, end: float) -> float:
        """Which share of the last stride the hand was seen in, from its first frame there on."""
        first = bisect_left(self._t, end - STRIDE - ROUNDED)
        return self._coverage(first, end, STRIDE) if first < len(self._t) else 0.0

    def _coverage(self, first: int, end: float, span: float) -> float:
        """Which share of a while up to `end` the hand was seen in, from a row on."""
        stamps = self._t[first:]
        gap = max(map(sub, stamps[1:], stamps), default=0.0)
        return max(0.0, min(1.0, (end - stamps[0]) / span) - (gap / span if gap > GAP else 0.0))

    def _since(self, begin: float) -> list[_Row]:
        return self._rows[bisect_left(self._t, begin - ROUNDED) :]


def _kept(values: Sequence[float], share: float) -> float:
    """What a share of the values lies below; NaN of too few to tell."""
    return quantile(values, share) if len(values) > 2 else math.nan


def _excused(against: float, share: float) -> float:
    """What speaks against a gesture counts less by a share, at most 1."""
    return against * min(1.0, 1.0 - share) if against < 0.0 < share else against


def _freed(favour: float, share: float) -> float:
    """What speaks for a gesture counts by a share, as far as nothing else explains it."""
    return favour * share if favour > 0.0 else favour


def near_enough(distance: float) -> float:
    """How surely a person is near enough for a close salutation; one half when unknown [m]."""
    near = logistic((HANDSHAKE_DISTANCE - distance) / SOFTNESS)
    return near if near == near else 0.5


def shoulder_of(own: Vec3, other: Vec3, head: Vec3) -> Vec3:
    """A shoulder, or the best there is in its place: the other one, or below the face [m]."""
    if own[2] == own[2]:
        return own
    if other[2] == other[2]:
        return other
    x, y, z = head
    return (x, y, z - FACE_OVER_SHOULDER) if z == z else UNKNOWN_POINT
