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
from typing import NamedTuple

from kendon.features.gestures.evidence import Weighing, posterior
from kendon.features.gestures.series import Series, quantile
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
#: A swing to and fro is looked for over so long: one period of a slow wave [s].
SWING = 0.7
#: How high the other hand came is asked of so long: more than half a stride [s].
STRIDE = 1.2

# Waves.
HEIGHT = Weighing(-0.25, 0.15, -3.0, 2.5)  # of the wrist over the shoulder [arms]
HELD_HEIGHT = Weighing(-0.40, 0.12, -3.0, 2.5)  # the same, where it is held
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


class HandGestures(NamedTuple):
    """Probabilities of what one hand does; NaN = unknown."""

    wave: float
    handshake: float


class Arm:
    """One arm over the latest seconds."""

    def __init__(self) -> None:
        self.up = Series()  # [m], wrist over shoulder
        self.toward = Series()  # [m], wrist from shoulder toward the robot, over the ground
        self.across = Series()  # [m], wrist from shoulder to the left as seen from the robot
        self.forearm = Series()  # [1], sine of the forearm's elevation
        self._upper_arm = Series()  # [m], length
        self._lower_arm = Series()  # [m], length

    def clear(self) -> None:
        """Forget everything."""
        for series in (
            self.up, self.toward, self.across, self.forearm, self._upper_arm, self._lower_arm
        ):  # fmt: skip
            series.clear()

    def add(self, t: float, shoulder: Vec3, elbow: Vec3, wrist: Vec3) -> None:
        """Take in the joints at an instant; NaN where they are not known."""
        sx, sy, sz = shoulder
        ex, ey, ez = elbow
        wx, wy, wz = wrist
        dx, dy = wx - sx, wy - sy
        way = math.sqrt(sx * sx + sy * sy)
        self.up.add(t, wz - sz)
        if way > 0.0:
            self.toward.add(t, -(dx * sx + dy * sy) / way)
            self.across.add(t, (dx * sy - dy * sx) / way)
        ax, ay, az = wx - ex, wy - ey, wz - ez
        length = math.sqrt(ax * ax + ay * ay + az * az)
        if length > 0.0:
            self.forearm.add(t, az / length)
            self._lower_arm.add(t, length)
        bx, by, bz = ex - sx, ey - sy, ez - sz
        self._upper_arm.add(t, math.sqrt(bx * bx + by * by + bz * bz))

    def length(self, begin: float) -> float:
        """Of upper and lower arm together, from an instant on [m]; NaN when unknown."""
        whole = quantile(self._upper_arm.since(begin), 0.5) + quantile(
            self._lower_arm.since(begin), 0.5
        )
        return whole if SHORTEST <= whole <= LONGEST else math.nan

    def noise(self, begin: float) -> float:
        """Standard deviation of a joint's place, as the bones tell it [m]; 0 when unknown."""
        worst = 0.0
        for bone in (self._upper_arm, self._lower_arm):
            lengths = bone.since(begin)
            if len(lengths) > 2:
                middle = quantile(lengths, 0.5)
                spread = quantile([abs(length - middle) for length in lengths], 0.5) / 0.6745
                worst = max(worst, spread)
        return worst

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
        if not self.up.since(since):
            return HandGestures(math.nan, math.nan)
        begin = min(end - NOW, since)
        noise = self.noise(end - 1.0) / arm
        count = len(self.up.since(begin))
        noise_now = noise / math.sqrt(count)

        def now(series: Series) -> float:
            return quantile(series.since(begin), 0.5)

        def held(series: Series) -> float:
            span = series.since(end - HOLD)
            return quantile(span, LET_GO) / arm if len(span) > 2 else math.nan

        height = now(self.up) / arm
        forearm = now(self.forearm)
        others = [value / arm for value in other.up.since(end - STRIDE)]
        alone = height - quantile(others, 0.9)
        sway = self.across.swing(end - SWING) / arm
        wave = posterior(
            WAVE_PRIOR,
            (
                HEIGHT.evidence(height, noise_now),
                HELD_HEIGHT.evidence(held(self.up), noise_now),
                UPRIGHT.evidence(forearm, 2.0 * noise_now),
                SWAY.evidence(sway, noise),
                ALONE.evidence(alone, noise_now),
            ),
        )
        reach = now(self.toward) / arm
        handshake = posterior(
            SHAKE_PRIOR,
            (
                REACH.evidence(reach, noise_now),
                HELD_REACH.evidence(held(self.toward), noise_now),
                LIFT.evidence(forearm, 2.0 * noise_now),
                HALFWAY.evidence(reach * arm / distance, noise_now),
                SHAKE.evidence(self.up.swing(end - SWING) / arm, noise),
                NEAR.evidence(distance),
            ),
        )
        return HandGestures(wave, handshake)


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
