"""Waves and handshakes, from one arm.

An arm is described by where the wrist is from its shoulder: how high, how far toward the robot
and how far to the side, and by how upright the forearm is. All of it is relative to the person,
so that neither the robot's motion nor a walk is taken for a gesture.

A wave is a hand held up beside the head, forearm upright, mostly swinging to and fro once to
three times a second. What looks like it for a moment is the arm swing of a brisk walk: there the
hand comes up for less than half a second, and the other hand has just been as high. A handshake
is a hand held out to the partner between waist and chest, with the forearm near the horizontal,
then shaken up and down; an arm that swings forward in a walk hangs straight and goes back soon.

Lengths are in units of the arm, shoulder to wrist. How sure the joints are is told by the bones:
their lengths do not change, so what changes in them is the noise of the joints.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import NamedTuple

from kendon.features.gestures.evidence import Weighing, posterior
from kendon.features.gestures.series import ROUNDED, quantile, spread
from kendon.geometry import UNKNOWN_POINT, Vec3

#: The arm from shoulder to wrist, of a person 1.7 m tall: 0.332 of the stature (Winter 2009) [m].
ARM = 0.56
#: The longest and shortest arms there are, from a small child to a very tall adult [m].
SHORTEST, LONGEST = 0.3, 0.8

#: Probabilities of one hand's gestures in any 0.2 s of an encounter.
WAVE_PRIOR = 0.04
SHAKE_PRIOR = 0.04

#: Where the hand is is told by the median of so long [s].
NOW = 0.25
#: A hand is held where it has been for so long, about as long as an arm swing is up [s].
HOLD = 0.45
#: All but this share of the while a hand must have been up, or out, to be held there.
LET_GO = 0.25
#: A hand that lasts there stays longer than any arm swing, most of a stride; a swing to and fro
#: is looked for over as long: one period of a slow wave [s].
LAST = 0.8
#: A hand is up from here on [arms over the shoulder].
RAISED = -0.5
#: How high the other hand came is asked of so long: more than half a stride [s].
STRIDE = 1.2

# Waves.
HEIGHT = Weighing(-0.25, 0.15, -3.0, 2.0)  # of the wrist over the shoulder [arms]
HELD_HEIGHT = Weighing(-0.40, 0.12, -3.0, 2.0)  # the same, where it is held
LASTING_HEIGHT = Weighing(-0.45, 0.12, -2.0, 2.0)  # the same, where it lasts
UPRIGHT = Weighing(0.30, 0.25, -2.0, 1.5)  # forearm: -1 hangs, 0 horizontal, 1 upright
SWAY = Weighing(0.06, 0.04, -0.7, 2.0)  # of a hand that is up, to and fro [arms]
ALONE = Weighing(0.20, 0.12, -2.5, 1.0)  # height over the other hand's highest [arms]

# Handshakes.
REACH = Weighing(0.50, 0.10, -3.0, 2.0)  # toward the robot [arms]
HELD_REACH = Weighing(0.40, 0.10, -3.0, 2.0)  # the same, where it is held
LIFT = Weighing(-0.30, 0.18, -2.5, 1.5)  # forearm, as above; a hanging arm swings at -0.7
HALFWAY = Weighing(0.35, 0.10, -2.0, 1.5)  # share of the way to the robot the hand is out
SHAKE = Weighing(0.05, 0.04, -0.3, 1.5)  # of a hand that is out, up and down [arms]
NEAR = Weighing(1.8, -0.2, -7.0, 1.0)  # the person from the robot [m]


#: No hand reaches a robot that is farther away [m].
FAR = 3.0
#: So long a row is kept [s]; it is let go of when twice as old.
_KEPT = 1.5 * STRIDE
#: The quartiles of a normal variable lie so many standard deviations apart.
QUARTILES = 1.349

#: One frame's wrist over the shoulder [m], toward the robot and across it [m], sine of the
#: forearm's elevation, length of lower and upper arm [m].
_Row = tuple[float, float, float, float, float, float]
_UP, _TOWARD, _ACROSS, _FOREARM, _LOWER, _UPPER = range(6)


class HandGestures(NamedTuple):
    """Probabilities of what one hand does; NaN = unknown."""

    wave: float
    handshake: float


class Arm:
    """One arm over the latest seconds."""

    def __init__(self) -> None:
        self._t: list[float] = []  # [s]
        self._rows: list[_Row] = []

    def clear(self) -> None:
        """Forget everything."""
        self._t.clear()
        self._rows.clear()

    def add(self, t: float, shoulder: Vec3, elbow: Vec3, wrist: Vec3) -> None:
        """Take in the joints at an instant; NaN where they are not known."""
        sx, sy, sz = shoulder
        wx, wy, wz = wrist
        up = wz - sz
        if up != up:  # NaN: nothing is known of this hand
            return
        stamps = self._t
        if stamps and t - stamps[0] > 2 * _KEPT:
            old = bisect_left(stamps, t - _KEPT)
            del stamps[:old], self._rows[:old]
        ex, ey, ez = elbow
        dx, dy = wx - sx, wy - sy
        ax, ay, az = wx - ex, wy - ey, wz - ez
        bx, by, bz = ex - sx, ey - sy, ez - sz
        way = math.sqrt(sx * sx + sy * sy) or math.nan
        lower = math.sqrt(ax * ax + ay * ay + az * az) or math.nan
        upper = math.sqrt(bx * bx + by * by + bz * bz)
        stamps.append(t)
        self._rows.append(
            (up, -(dx * sx + dy * sy) / way, (dx * sy - dy * sx) / way, az / lower, lower, upper)
        )

    def _since(self, begin: float) -> list[_Row]:
        return self._rows[bisect_left(self._t, begin - ROUNDED) :]

    def length(self, begin: float) -> float:
        """Of upper and lower arm together, from an instant on [m]; NaN when unknown."""
        whole = quantile([row[_LOWER] + row[_UPPER] for row in self._since(begin)], 0.5)
        return whole if SHORTEST <= whole <= LONGEST else math.nan

    def highest(self, begin: float) -> float:
        """How high over its shoulder the hand has been, from an instant on [m]."""
        return quantile([row[_UP] for row in self._since(begin)], 0.9)

    def gestures(
        self, end: float, since: float, arm: float, other: Arm, distance: float
    ) -> HandGestures:
        """What this hand does in an interval.

        Args:
            end: of the interval [s].
            since: its first frame [s].
            arm: the arm's length [m].
            other: the other arm.
            distance: of the person from the robot; NaN when unknown [m].
        """
        if not self._t or self._t[-1] < since - ROUNDED:
            return HandGestures(math.nan, math.nan)
        now = self._since(min(end - NOW, since))
        held = self._since(end - HOLD)
        lasting = self._since(end - LAST)
        noise = _noise(lasting) / arm
        # A while that has only begun tells as much less.
        age = end - self._t[0]
        stride = min(1.0, (end - other._t[0]) / STRIDE) if other._t else 0.0
        noise_now = noise / math.sqrt(len(now))

        height = quantile([row[_UP] for row in now], 0.5) / arm
        forearm = quantile([row[_FOREARM] for row in now], 0.5)
        while_up = [row[_ACROSS] for row in lasting if row[_UP] > RAISED * arm]
        wave = posterior(
            WAVE_PRIOR,
            (
                HEIGHT.evidence(height, noise_now),
                min(1.0, age / HOLD)
                * HELD_HEIGHT.evidence(_kept([row[_UP] for row in held]) / arm, noise_now),
                min(1.0, age / LAST)
                * LASTING_HEIGHT.evidence(_kept([row[_UP] for row in lasting]) / arm, noise_now),
                UPRIGHT.evidence(forearm, 2.0 * noise_now),
                SWAY.evidence(spread(while_up) / arm, noise),
                stride * ALONE.evidence(height - other.highest(end - STRIDE) / arm, noise_now),
            ),
        )
        if distance > FAR:
            return HandGestures(wave, 0.0)
        reach = quantile([row[_TOWARD] for row in now], 0.5)
        ways_out = [row[_TOWARD] for row in held]
        handshake = posterior(
            SHAKE_PRIOR,
            (
                REACH.evidence(reach / arm, noise_now),
                min(1.0, age / HOLD) * HELD_REACH.evidence(_kept(ways_out) / arm, noise_now),
                LIFT.evidence(forearm, 2.0 * noise_now),
                HALFWAY.evidence(reach / distance, noise_now),
                SHAKE.evidence(spread([row[_UP] for row in lasting if row[_TOWARD] > 0.4 * arm]) / arm, noise),
                NEAR.evidence(distance),
            ),
        )
        return HandGestures(wave, handshake)


def _kept(values: list[float]) -> float:
    """What nearly all of the values reach; NaN of too few to tell."""
    return quantile(values, LET_GO) if len(values) > 2 else math.nan


def _noise(rows: list[_Row]) -> float:
    """The standard deviation of a joint's place, as the bones tell it [m]; 0 when unknown."""
    worst = 0.0
    for bone in (_LOWER, _UPPER):
        lengths = sorted([row[bone] for row in rows if row[bone] == row[bone]])
        if len(lengths) > 3:
            count = len(lengths)
            worst = max(worst, (lengths[3 * count // 4] - lengths[count // 4]) / QUARTILES)
    return worst


def shoulder_of(own: Vec3, other: Vec3, head: Vec3) -> Vec3:
    """A shoulder, or the best there is in its place [m].

    The other shoulder is as high; the face is higher by 0.118 of the stature (Winter 2009).
    """
    if own[2] == own[2]:
        return own
    if other[2] == other[2]:
        return other
    x, y, z = head
    return (x, y, z - 0.2) if z == z else UNKNOWN_POINT
