"""Motions of joints within their limits: through keyframes, or after a target that moves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.interpolate import CubicHermiteSpline, pchip_interpolate

from kendon.person import FloatArray
from kendon.robots.drive import speed_within, way_of_step

#: Of a joint's greatest speed, gestures use at most this share: the rest is left to the servos,
#: which lag a little and then catch up.
SPEED_SHARE = 0.9


class Motion:
    """The set-points of some joints over time, sampled once a control cycle.

    Args:
        joints: their indices, (J,).
        points: (N, J) set-points [rad or m], one row a cycle, the first one cycle after the start.
    """

    __slots__ = ("_row", "joints", "points")

    def __init__(self, joints: Sequence[int], points: FloatArray) -> None:
        self.joints = np.array(joints, dtype=np.int64)
        self.points = points
        self._row = 0

    @property
    def over(self) -> bool:
        """Whether the last set-point has been taken."""
        return self._row == len(self.points)

    def next(self) -> FloatArray:
        """The set-points of the next cycle, (J,); the last ones again when it is over."""
        row = min(self._row, len(self.points) - 1)
        self._row = min(self._row + 1, len(self.points))
        now: FloatArray = self.points[row]
        return now


def plan(
    keyframes: Sequence[tuple[float, Mapping[int, float]]],
    start: FloatArray,
    velocity: FloatArray,
    low: FloatArray,
    high: FloatArray,
    speeds: FloatArray,
    cycle: float,
) -> Motion:
    """The motion through keyframes, each joint through those that name it.

    Between keyframes a joint follows a cubic with the slopes of Fritsch and Carlson (1980): it
    never swings beyond two neighbouring keyframes, comes to rest where it turns around and at
    the end, and passes smoothly through the others. A motion that would be too fast for one
    joint takes longer as a whole, so that all stay together.

    Args:
        keyframes: (time since the start [s], joint index -> set-point [rad or m]).
        start: the present set-points of all joints [rad or m].
        velocity: how fast these move [rad/s or m/s].
        low: the lowest set-points of all joints.
        high: the highest.
        speeds: the joints' greatest speeds [rad/s or m/s].
        cycle: how long a control cycle is [s].
    """
    joints: list[int] = []
    curves: list[CubicHermiteSpline] = []
    stretch = 1.0
    for times, together in _by_times(keyframes).items():
        angles = dict(keyframes)
        t = np.array([0.0, *times])
        x = np.array([start[together], *([angles[at][j] for j in together] for at in times)])
        curve = CubicHermiteSpline(t, x, _slopes(t, x, velocity[together]))
        stretch = max(stretch, float((_fastest(curve) / (SPEED_SHARE * speeds[together])).max()))
        joints += together
        curves.append(curve)
    seconds = keyframes[-1][0] * stretch
    count = max(1, int(np.ceil(seconds / cycle - 1e-9)))
    at = np.minimum(np.arange(1, count + 1) * cycle, seconds) / stretch
    # A joint keeps its last keyframe's place to the end of the motion.
    points = np.concatenate([curve(np.minimum(at, curve.x[-1])) for curve in curves], axis=1)
    return Motion(joints, np.clip(points, low[joints], high[joints]))


def _by_times(
    keyframes: Sequence[tuple[float, Mapping[int, float]]],
) -> dict[tuple[float, ...], list[int]]:
    """The joints that are named by the same keyframes, by these keyframes' times."""
    groups: dict[tuple[float, ...], list[int]] = {}
    for joint in sorted({joint for _, angles in keyframes for joint in angles}):
        times = tuple(t for t, angles in keyframes if joint in angles)
        groups.setdefault(times, []).append(joint)
    return groups


def _slopes(t: FloatArray, x: FloatArray, velocity: FloatArray) -> FloatArray:
    slopes = np.zeros_like(x)
    if len(t) > 2:
        # The harmonic mean of a slope next to nothing passes infinity on its way to zero.
        with np.errstate(over="ignore"):
            slopes[1:-1] = pchip_interpolate(t, x, t, der=1)[1:-1]
    slopes[0] = velocity
    return slopes


def _fastest(curve: CubicHermiteSpline) -> FloatArray:
    """The greatest speeds along a curve: at a keyframe or where the acceleration passes zero."""
    a, b, c, _ = curve.c  # of each stretch, from the cube down, (4, N, J)
    span = np.diff(curve.x)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        bend = np.clip(np.nan_to_num(-b / (3 * a)), 0, span)
    candidates = [c, c + 2 * b * span + 3 * a * span**2, c + 2 * b * bend + 3 * a * bend**2]
    fastest: FloatArray = np.abs(candidates).max(axis=(0, 1))
    return fastest


class Chaser:
    """One set-point that follows a target with limited speed and acceleration.

    Args:
        position: where it starts [rad or m].
        speed: its greatest speed [rad/s or m/s].
        acceleration: its greatest acceleration, also the braking [rad/s^2 or m/s^2].
    """

    __slots__ = ("acceleration", "position", "rate", "speed")

    def __init__(self, position: float, speed: float, acceleration: float) -> None:
        self.position = position
        self.speed = speed
        self.acceleration = acceleration
        self.rate = 0.0  # [rad/s or m/s]

    def step(self, target: float | None, h: float) -> None:
        """Go on for `h` [s] toward a target, or brake where there is none."""
        wanted = 0.0
        if target is not None:
            error = target - self.position
            if abs(error) < 1e-6 and self.rate == 0:
                return
            side = math.copysign(1.0, error)
            near = speed_within(abs(error), side * self.rate, self.acceleration, h)
            wanted = side * min(self.speed, near)
        change = self.acceleration * h
        rate = min(max(wanted, self.rate - change), self.rate + change)
        rate = 0.0 if abs(rate) < 1e-6 else rate
        self.position += way_of_step(self.rate, rate, self.acceleration, h)
        self.rate = rate
