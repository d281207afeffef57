"""Waves and handshakes: evidence from one arm.

An arm is described by where the wrist is from its shoulder: how high, how far toward the robot
and how far across, and by how upright the forearm is. All of it is relative to the person, so
that neither the robot's motion nor a walk is taken for a gesture.

A wave is a hand held up beside the head, forearm upright, mostly swinging to and fro once to
three times a second. What looks like it for a moment is the arm swing of a brisk walk: there the
hand comes up for less than half a second, and the other hand has just been as high. A hand at the
hair, the face or a telephone is as high, but stays close to the head. A handshake is a hand held
out to the partner between waist and chest, to about halfway, and shaken up and down; an arm that
swings forward in a walk goes back soon.

Lengths are in units of the arm, shoulder to wrist. How sure the joints are is told by the bones:
their lengths do not change, so what changes in them is the noise of the joints.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import NamedTuple

from kendon.features.gestures.evidence import Weighing
from kendon.features.gestures.series import ROUNDED, change, quantile, spread
from kendon.geometry import UNKNOWN_POINT, Vec3

#: The arm from shoulder to wrist, of a person 1.7 m tall: 0.332 of the stature (Winter 2009) [m].
ARM = 0.56
#: The longest and shortest arms there are, from a small child to a very tall adult [m].
SHORTEST, LONGEST = 0.3, 0.8
#: The shoulder is lower than the middle of the face: 0.085 of that stature (Winter 2009) [m].
FACE_OVER_SHOULDER = 0.145

#: Where the hand is is told by the median of so long [s].
NOW = 0.25
#: A hand is held where it has been for so long, about as long as an arm swing is up [s].
HOLD = 0.45
#: A hand that lasts there stays longer than any arm swing, most of a stride; a swing to and fro
#: is looked for over as long: one period of a slow wave [s].
LAST = 0.8
#: All but this share of the while a hand must have been up, or out, to be held there.
LET_GO = 0.25
#: How high the other hand came is asked of so long: more than half a stride [s].
STRIDE = 1.2
#: Hands are up, or out, from here on [arms over the shoulder, arms before it].
RAISED, OUT = -0.5, 0.4
#: Who lifts both hands keeps them this near to where they were highest [arms].
TOGETHER = 0.15
#: So long a row is kept [s]; it is let go of when twice as old.
KEPT = 1.5 * STRIDE


class WaveEvidence(NamedTuple):
    """What speaks for a wave with one hand."""

    height: float
    lasting: float
    upright: float
    sway: float
    alone: float
    apart: float


class HandshakeEvidence(NamedTuple):
    """What speaks for a handshake with one hand."""

    reach: float
    held: float
    halfway: float
    shake: float
    near: float


# Waves.
HEIGHT = Weighing(-0.25, 0.15, -3.0, 2.0)  # of the wrist over the shoulder [arms]
LASTING = Weighing(-0.45, 0.12, -2.0, 2.0)  # the same, where it lasts
UPRIGHT = Weighing(0.30, 0.25, -2.0, 2.0)  # forearm: -1 hangs, 0 horizontal, 1 upright
SWAY = Weighing(0.08, 0.04, -1.0, 3.0)  # to and fro of a hand that is up, standard dev. [arms]
ALONE = Weighing(0.20, 0.12, -2.5, 1.0)  # height over the other hand's highest [arms]
APART = Weighing(0.35, 0.07, -3.0, 1.5)  # wrist from the face, as seen from the robot [arms]

# Handshakes.
REACH = Weighing(0.50, 0.10, -3.0, 2.0)  # toward the robot [arms]
HELD_REACH = Weighing(0.40, 0.10, -3.0, 2.0)  # the same, where it is held
HALFWAY = Weighing(0.35, 0.10, -2.0, 1.5)  # share of the way to the robot the hand is out
SHAKE = Weighing(0.05, 0.04, -0.3, 1.5)  # up and down of a hand that is out, std. dev. [arms]
NEAR = Weighing(1.8, -0.2, -7.0, 1.0)  # the person from the robot [m]

#: One frame's wrist over the shoulder [m], toward the robot and across it [m], sine of the
#: forearm's elevation, length of both bones together [m], wrist from the face [m].
_Row = tuple[float, float, float, float, float, float]
_UP, _TOWARD, _ACROSS, _FOREARM, _LENGTH, _APART = range(6)


class Arm:
    """One arm over the latest seconds."""

    def __init__(self) -> None:
        self._t: list[float] = []  # [s]
        self._rows: list[_Row] = []

    def clear(self) -> None:
        """Forget everything."""
        self._t.clear()
        self._rows.clear()

    def add(self, t: float, shoulder: Vec3, elbow: Vec3, wrist: Vec3, head: Vec3) -> None:
        """Take in the joints and the face at an instant; NaN where they are not known."""
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
        dx, dy = wx - sx, wy - sy
        ax, ay, az = wx - ex, wy - ey, wz - ez
        bx, by, bz = ex - sx, ey - sy, ez - sz
        way = math.sqrt(sx * sx + sy * sy) or math.nan
        lower = math.sqrt(ax * ax + ay * ay + az * az) or math.nan
        beside, above = ((wx - hx) * sy - (wy - hy) * sx) / way, wz - hz
        stamps.append(t)
        self._rows.append(
            (
                up,
                -(dx * sx + dy * sy) / way,
                (dx * sy - dy * sx) / way,
                az / lower,
                lower + math.sqrt(bx * bx + by * by + bz * bz),
                math.sqrt(beside * beside + above * above),
            )
        )

    def length(self, begin: float) -> float:
        """Of upper and lower arm together, from an instant on [m]; NaN when unknown."""
        whole = quantile([row[_LENGTH] for row in self._since(begin)], 0.5)
        return whole if SHORTEST <= whole <= LONGEST else math.nan

    def evidence(
        self, end: float, since: float, arm: float, other: Arm, distance: float
    ) -> tuple[WaveEvidence, HandshakeEvidence]:
        """What this hand does in an interval in which it is seen.

        Args:
            end: of the interval [s].
            since: its first frame [s].
            arm: the arms' length [m].
            other: the other arm.
            distance: of the person from the robot; NaN when unknown [m].
        """
        begin = min(end - NOW, since)
        now, held, lasting = self._since(begin), self._since(end - HOLD), self._since(end - LAST)
        noise = change([row[_LENGTH] for row in lasting]) / arm
        noise_now = noise / math.sqrt(len(now))
        # A while of which only the end was seen tells as much less.
        held_share, lasting_share = self._covered(end, HOLD), self._covered(end, LAST)

        height = quantile([row[_UP] for row in now], 0.5) / arm
        forearm = quantile([row[_FOREARM] for row in now], 0.5)
        swaying = [row[_ACROSS] for row in lasting if row[_UP] > RAISED * arm]
        apart = quantile([row[_APART] for row in lasting], 1.0 - LET_GO) / arm
        lasts = lasting_share * LASTING.evidence(
            _kept([row[_UP] for row in lasting]) / arm, noise_now
        )
        sway = SWAY.evidence(spread(swaying) / arm, noise)
        if lasts < 0.0 < sway:
            # A hand that comes and goes is an arm swing, however far it goes aside.
            sway *= 1.0 - lasts / LASTING.least
        alone = other.covered(end) * ALONE.evidence(
            height - other.swung(begin, end, arm), noise_now
        )
        if alone < 0.0 < lasts:
            # A hand that lasts is no arm swing, however high the other one swings.
            alone *= 1.0 - lasts / LASTING.most
        wave = WaveEvidence(
            HEIGHT.evidence(height, noise_now),
            lasts,
            UPRIGHT.evidence(forearm, 2.0 * noise_now),
            sway,
            alone,
            APART.evidence(apart, noise_now),
        )
        reach = quantile([row[_TOWARD] for row in now], 0.5)
        shaking = [row[_UP] for row in lasting if row[_TOWARD] > OUT * arm]
        handshake = HandshakeEvidence(
            REACH.evidence(reach / arm, noise_now),
            held_share
            * HELD_REACH.evidence(_kept([row[_TOWARD] for row in held]) / arm, noise_now),
            HALFWAY.evidence(reach / distance, noise_now),
            SHAKE.evidence(spread(shaking) / arm, noise),
            NEAR.evidence(distance),
        )
        return wave, handshake

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
        return self._covered(end, STRIDE)

    def _covered(self, end: float, span: float) -> float:
        first = bisect_left(self._t, end - span - ROUNDED)
        if first == len(self._t):
            return 0.0
        return min(1.0, (end - self._t[first]) / span)

    def _since(self, begin: float) -> list[_Row]:
        return self._rows[bisect_left(self._t, begin - ROUNDED) :]


def _kept(values: list[float]) -> float:
    """What nearly all of the values reach; NaN of too few to tell."""
    return quantile(values, LET_GO) if len(values) > 2 else math.nan


def shoulder_of(own: Vec3, other: Vec3, head: Vec3) -> Vec3:
    """A shoulder, or the best there is in its place: the other one, or below the face [m]."""
    if own[2] == own[2]:
        return own
    if other[2] == other[2]:
        return other
    x, y, z = head
    return (x, y, z - FACE_OVER_SHOULDER) if z == z else UNKNOWN_POINT
