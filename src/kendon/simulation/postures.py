"""How movements bend heads, trunks and arms, at one instant or over time (`limbs.Curve`).

Points of a posture are shares of stature from the middle between the shoulders: x forward, y
outward on the arm's own side, z up along the trunk. They are ours, tried on one's own body.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kendon.simulation.body import Body
from kendon.simulation.limbs import (
    Arm,
    Curve,
    Vector,
    blend,
    cos,
    min_jerk,
    reach,
    sin,
)
from kendon.simulation.movements import Movement

#: How much of its length a hand held out for a handshake takes of an arm.
_HELD_OUT = 0.93
#: How far below the shoulder it is held at most, likewise: tall people reach down no farther.
_LOWEST = 0.7


@dataclass(slots=True)
class Pose:
    """Angles of a body; arms as if both were left ones."""

    trunk: Curve  # forward [rad]
    head: Curve  # further down than the look [rad]
    arms: dict[str, Arm]


def play(pose: Pose, body: Body, movement: Movement, t: Curve) -> None:
    """Add one movement to a pose, in place; times grow [s]."""
    if isinstance(t, float):
        if movement.begin <= t < movement.end:
            _add(pose, body, movement, t - movement.begin)
        return
    first, last = np.searchsorted(t, (movement.begin, movement.end))
    if first < last:
        during = slice(int(first), int(last))
        part = Pose(
            pose.trunk[during], pose.head[during],
            {side: _part(arm, during) for side, arm in pose.arms.items()},
        )  # fmt: skip
        _add(part, body, movement, t[during] - movement.begin)
        pose.trunk[during], pose.head[during] = part.trunk, part.head
        for side in movement.hands:
            _write(part.arms[side], pose.arms[side], during)


def _part(arm: Arm, during: slice) -> Arm:
    x, y, z, w = arm.shoulder
    return Arm((x[during], y[during], z[during], w[during]), arm.elbow[during])


def _write(part: Arm, whole: Arm, during: slice) -> None:
    for values, into in zip(
        (*part.shoulder, part.elbow), (*whole.shoulder, whole.elbow), strict=True
    ):
        into[during] = values


def _add(pose: Pose, body: Body, m: Movement, since: Curve) -> None:
    """Add a movement that is going on, since when [s]."""
    shown = min_jerk(since / m.rise) * min_jerk((m.duration - since) / m.fall)
    if m.lean:
        pose.trunk = pose.trunk + m.lean * shown
    if m.kind in _HEAD:
        _HEAD[m.kind](pose, m, since, shown)
    for side in m.hands:
        (x, y, z), pole = _ARMS[m.kind](body, m, side, since, pose.trunk)
        there = reach((x, y - body.half_shoulders, z), pole, body.upper_arm, body.forearm)
        pose.arms[side] = blend(pose.arms[side], there, shown)


def _beats(m: Movement, since: Curve, begin: float) -> Curve:
    """Strokes between rise and fall, from -1 to 1, swelling and dying within half a stroke."""
    half = 0.5 / m.rate
    swell = min_jerk((since - begin) / half) * min_jerk((m.duration - m.fall - since) / half)
    return sin(2 * math.pi * m.rate * (since - begin)) * swell


# ---- heads and trunks


def _nod(pose: Pose, m: Movement, since: Curve, shown: Curve) -> None:
    # The first nod is the deepest.
    deep = 1 - 0.4 * since / m.duration
    pose.head = pose.head + m.size * deep * shown * (1 - cos(2 * math.pi * m.rate * since)) / 2


def _down(pose: Pose, m: Movement, since: Curve, shown: Curve) -> None:
    pose.head = pose.head + m.size * shown


def _up(pose: Pose, m: Movement, since: Curve, shown: Curve) -> None:
    pose.head = pose.head - m.size * shown


def _bow(pose: Pose, m: Movement, since: Curve, shown: Curve) -> None:
    pose.trunk = pose.trunk + m.size * shown
    pose.head = pose.head + m.size * shown


_HEAD: dict[str, Callable[[Pose, Movement, Curve, Curve], None]] = {
    "nod": _nod, "toss": _up, "dip": _down, "bow": _bow, "text": _down, "watch": _down,
}  # fmt: skip


# ---- arms: where the wrist is [m] and where the elbow points


_Held = tuple[Vector, tuple[float, float, float]]


def _raised(body: Body, m: Movement, side: str, since: Curve, trunk: Curve) -> _Held:
    h, k = m.height, body.stature
    x, y, z = (0.13 - 0.09 * h) * k, (0.19 + 0.04 * (m.aside - h)) * k, (0.02 + 0.26 * h) * k
    pole = (-0.2 + 0.3 * h, 0.3 + 0.6 * h, -1.0 + 0.6 * h)
    if m.rate == 0:
        return (x, y, z), pole
    aside = m.size / 2 * _beats(m, since, m.rise)
    # Along an arc about the elbow.
    return (x, y + aside, z - aside * aside / (2 * body.forearm)), pole


def _handshake(body: Body, m: Movement, side: str, since: Curve, trunk: Curve) -> _Held:
    """Held out over the floor, however the trunk leans."""
    lean = body.stoop + m.lean
    across = m.aside * body.half_shoulders
    shoulder = body.torso * math.cos(lean)  # above the hips, as all that follows
    up = max(m.height - body.hip_height, shoulder - _LOWEST * body.reach)
    drop = up - shoulder
    ahead = math.sqrt(max((_HELD_OUT * body.reach) ** 2 - drop**2 - across**2, 0.01))
    ahead += body.torso * math.sin(lean)
    height = up + m.size / 2 * _beats(m, since, m.rise + m.wait)
    s, c = sin(trunk), cos(trunk)
    x, z = c * ahead - s * height, s * ahead + c * height - body.torso
    return (x, body.half_shoulders + across, z), (-0.3, 0.4, -1.0)


def _hug(body: Body, m: Movement, side: str, since: Curve, trunk: Curve) -> _Held:
    k = body.stature
    closed = min_jerk((since - 0.8 * m.rise) / 0.7) * min_jerk((m.duration - since) / m.fall)
    y = 0.11 + (0.25 * m.size) * (1 - closed) - 0.09 * closed
    up = 0.1 * (m.height if side == body.handed else -m.height)
    return (0.23 * k, y * k, (0.02 + 0.5 * m.height + up * closed) * k), (-0.1, 1.0, -0.6)


def _talk(body: Body, m: Movement, side: str, since: Curve, trunk: Curve) -> _Held:
    k = body.stature
    outward = 0.03 * max(0.0, m.height - 1.0)  # hands that are high are apart
    # Two rates that never meet again: beats do not come like clockwork.
    late = m.aside + (0.7 if side == "l" else 0.0)
    turn = 2 * math.pi * m.rate * since
    x = 0.16 * k + m.size / 2 * (1 + sin(0.8 * turn + 5 * late)) / 2
    y = (0.07 + outward) * k + m.size / 6 * sin(0.45 * turn + 3 * late)
    beats = sin(turn + late) + 0.8 * sin(0.618 * turn + 2 * late)
    z = (-0.13 + 0.05 * m.height) * k + m.size / 3.6 * beats
    return (x, y, z), (-0.3, 0.5, -1.0)


def _offer(body: Body, m: Movement, side: str, since: Curve, trunk: Curve) -> _Held:
    return _outstretched(body, m, m.size)


def _point(body: Body, m: Movement, side: str, since: Curve, trunk: Curve) -> _Held:
    return _outstretched(body, m, 0.96 * body.reach)


def _outstretched(body: Body, m: Movement, along: float) -> _Held:
    """A hand so far from its shoulder [m], at an elevation and an azimuth."""
    level = along * math.cos(m.height)
    x, y, z = level * math.cos(m.aside), level * math.sin(m.aside), along * math.sin(m.height)
    return (x, y + body.half_shoulders, z), (-0.2, 0.4, -1.0)


def _at(
    x: float, y: float, z: float, pole: tuple[float, float, float], height: float, aside: float
) -> Callable[[Body, Movement, str, Curve, Curve], _Held]:
    """A posture that is held, varied by so much up and sideways; the hand may stroke along."""

    def held(body: Body, m: Movement, side: str, since: Curve, trunk: Curve) -> _Held:
        # Nobody holds quite still.
        drift = 0.003 * sin(3.1 * since + m.aside)
        up, out = z + height * m.height, y + aside * m.aside
        k = body.stature
        wrist = (x + drift) * k, (out + drift) * k, (up + drift) * k
        if m.rate > 0:
            # Back over the head and down it, or along the cheek.
            stroke = m.size / 2 * sin(2 * math.pi * m.rate * since)
            wrist = wrist[0] - 0.5 * stroke, wrist[1] + 0.7 * stroke, wrist[2] - 0.5 * stroke
        return wrist, pole

    return held


_crossed_over = _at(0.13, -0.06, -0.12, (-0.3, 0.6, -1.0), 0.01, 0.01)
_crossed_under = _at(0.115, -0.05, -0.155, (-0.3, 0.6, -1.0), 0.01, 0.01)


def _crossed(body: Body, m: Movement, side: str, since: Curve, trunk: Curve) -> _Held:
    over = side == body.handed
    return (_crossed_over if over else _crossed_under)(body, m, side, since, trunk)


_ARMS: dict[str, Callable[[Body, Movement, str, Curve, Curve], _Held]] = {
    "wave": _raised,
    "raise": _raised,
    "handshake": _handshake,
    "hug": _hug,
    "talk": _talk,
    "offer": _offer,
    "point": _point,
    "watch": _at(0.16, 0.0, -0.09, (-0.1, 0.9, -0.7), 0.02, 0.02),
    "call": _at(0.06, 0.09, 0.05, (0.1, 0.6, -1.0), 0.02, 0.015),
    "text": _at(0.16, 0.03, -0.12, (-0.4, 0.5, -1.0), 0.03, 0.02),
    "face": _at(0.13, 0.05, 0.03, (-0.1, 0.6, -1.0), 0.03, 0.02),
    "hair": _at(0.05, 0.09, 0.13, (0.4, 1.0, -0.2), 0.03, 0.02),
    "pockets": _at(0.03, 0.115, -0.275, (-1.0, 0.6, 0.1), 0.015, 0.01),
    "crossed": _crossed,
    "bag": _at(0.01, 0.125, -0.325, (-1.0, 0.2, 0.0), 0.0, 0.01),
}
