"""How movements bend heads, trunks and arms.

Points of a posture are shares of stature from the middle between the shoulders: x forward, y
outward on the arm's own side, z up along the trunk. They are ours, tried on one's own body.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kendon.person import FloatArray
from kendon.simulation.body import Body
from kendon.simulation.limbs import Arm, blend, min_jerk, reach
from kendon.simulation.movements import Movement

#: How much of its length a hand held out for a handshake takes of an arm.
_HELD_OUT = 0.93
#: How far below the shoulder it is held at most, likewise: tall people reach down no farther.
_LOWEST = 0.7


@dataclass
class Pose:
    """Angles of a body over time, (N,) each; arms as if both were left ones."""

    trunk: FloatArray  # forward [rad]
    head: FloatArray  # further down than the look [rad]
    arms: dict[str, Arm]


def play(pose: Pose, body: Body, movement: Movement, t: FloatArray) -> None:
    """Add one movement to a pose, in place; t grows."""
    m = movement
    first, last = np.searchsorted(t, (m.begin, m.end))
    if first == last:
        return
    during = slice(int(first), int(last))
    since = t[during] - m.begin
    shown = min_jerk(since / m.rise) * min_jerk((m.duration - since) / m.fall)
    pose.trunk[during] += m.lean * shown
    if m.kind in _HEAD:
        _HEAD[m.kind](pose, m, during, since, shown)
    for side in m.hands:
        whole = pose.arms[side]
        now = Arm(whole.shoulder[:, during], whole.elbow[during])
        wrist, pole = _ARMS[m.kind](body, m, side, since, pose.trunk[during])
        wrist = np.subtract(wrist, [[0.0], [body.half_shoulders], [0.0]])
        there = reach(wrist, np.reshape(pole, (3, -1)), body.upper_arm, body.forearm)
        held = blend(now, there, shown)
        whole.shoulder[:, during], whole.elbow[during] = held


def _beats(m: Movement, since: FloatArray, begin: float) -> FloatArray:
    """Strokes between rise and fall, from -1 to 1, swelling and dying within half a stroke."""
    half = 0.5 / m.rate
    swell = min_jerk((since - begin) / half) * min_jerk((m.duration - m.fall - since) / half)
    return np.asarray(np.sin(2 * math.pi * m.rate * (since - begin)) * swell)


# ---- heads and trunks


def _nod(pose: Pose, m: Movement, at: slice, since: FloatArray, shown: FloatArray) -> None:
    # The first nod is the deepest.
    deep = 1 - 0.4 * since / m.duration
    pose.head[at] += m.size * deep * shown * (1 - np.cos(2 * math.pi * m.rate * since)) / 2


def _down(pose: Pose, m: Movement, at: slice, since: FloatArray, shown: FloatArray) -> None:
    pose.head[at] += m.size * shown


def _up(pose: Pose, m: Movement, at: slice, since: FloatArray, shown: FloatArray) -> None:
    pose.head[at] -= m.size * shown


def _bow(pose: Pose, m: Movement, at: slice, since: FloatArray, shown: FloatArray) -> None:
    pose.trunk[at] += m.size * shown
    pose.head[at] += m.size * shown


_HEAD: dict[str, Callable[[Pose, Movement, slice, FloatArray, FloatArray], None]] = {
    "nod": _nod, "toss": _up, "dip": _down, "bow": _bow, "text": _down, "watch": _down,
}  # fmt: skip


# ---- arms: where the wrist is [m] and where the elbow points


_Held = tuple[FloatArray, tuple[float, float, float]]


def _point_of(body: Body, since: FloatArray, x: float, y: float, z: float) -> FloatArray:
    return np.array([[x], [y], [z]]) * body.stature + 0 * since


def _raised(body: Body, m: Movement, side: str, since: FloatArray, trunk: FloatArray) -> _Held:
    h = m.height
    wrist = _point_of(body, since, 0.13 - 0.09 * h, 0.19 + 0.04 * (m.aside - h), 0.02 + 0.26 * h)
    if m.rate > 0:
        aside = m.size / 2 * _beats(m, since, m.rise)
        # Along an arc about the elbow.
        wrist[1] += aside
        wrist[2] -= aside * aside / (2 * body.forearm)
    return wrist, (-0.2 + 0.3 * h, 0.3 + 0.6 * h, -1.0 + 0.6 * h)


def _handshake(body: Body, m: Movement, side: str, since: FloatArray, trunk: FloatArray) -> _Held:
    """Held out over the floor, however the trunk leans."""
    lean = body.stoop + m.lean
    across = m.aside * body.half_shoulders
    shoulder = body.torso * math.cos(lean)  # above the hips, as all that follows
    up = max(m.height - body.hip_height, shoulder - _LOWEST * body.reach)
    drop = up - shoulder
    ahead = math.sqrt(max((_HELD_OUT * body.reach) ** 2 - drop**2 - across**2, 0.01))
    ahead += body.torso * math.sin(lean)
    height = up + m.size / 2 * _beats(m, since, m.rise + m.wait)
    s, c = np.sin(trunk), np.cos(trunk)
    y = np.full_like(since, body.half_shoulders + across)
    return np.array([c * ahead - s * height, y, s * ahead + c * height - body.torso]), (
        -0.3, 0.4, -1.0,
    )  # fmt: skip


def _hug(body: Body, m: Movement, side: str, since: FloatArray, trunk: FloatArray) -> _Held:
    wrist = _point_of(body, since, 0.23, 0.11, 0.02 + 0.5 * m.height)
    closed = min_jerk((since - 0.8 * m.rise) / 0.7) * min_jerk((m.duration - since) / m.fall)
    wrist[1] += body.stature * ((0.25 * m.size) * (1 - closed) - 0.09 * closed)
    wrist[2] += body.stature * 0.1 * (m.height if side == body.handed else -m.height) * closed
    return wrist, (-0.1, 1.0, -0.6)


def _talk(body: Body, m: Movement, side: str, since: FloatArray, trunk: FloatArray) -> _Held:
    outward = 0.03 * max(0.0, m.height - 1.0)  # hands that are high are apart
    wrist = _point_of(body, since, 0.16, 0.07 + outward, -0.13 + 0.05 * m.height)
    # Two rates that never meet again: beats do not come like clockwork.
    late = m.aside + (0.7 if side == "l" else 0.0)
    turn = 2 * math.pi * m.rate * since
    beats = np.sin(turn + late) + 0.8 * np.sin(0.618 * turn + 2 * late)
    wrist[2] += m.size / 3.6 * beats
    wrist[0] += m.size / 2 * (1 + np.sin(0.8 * turn + 5 * late)) / 2
    wrist[1] += m.size / 6 * np.sin(0.45 * turn + 3 * late)
    return wrist, (-0.3, 0.5, -1.0)


def _point(body: Body, m: Movement, side: str, since: FloatArray, trunk: FloatArray) -> _Held:
    along = 0.96 * body.reach
    level = along * math.cos(m.height)
    x, y, z = level * math.cos(m.aside), level * math.sin(m.aside), along * math.sin(m.height)
    return np.array([[x], [y + body.half_shoulders], [z]]) + 0 * since, (-0.2, 0.4, -1.0)


def _at(
    x: float, y: float, z: float, pole: tuple[float, float, float], height: float, aside: float
) -> Callable[[Body, Movement, str, FloatArray, FloatArray], _Held]:
    """A posture that is held, varied by so much up and sideways; the hand may stroke along."""

    def held(body: Body, m: Movement, side: str, since: FloatArray, trunk: FloatArray) -> _Held:
        # Nobody holds quite still.
        drift = 0.003 * np.sin(3.1 * since + m.aside)
        wrist = _point_of(body, since, x, y + aside * m.aside, z + height * m.height)
        if m.rate > 0:
            # Back over the head and down it, or along the cheek.
            stroke = m.size / 2 * np.sin(2 * math.pi * m.rate * since)
            wrist += np.array([[-0.5], [0.7], [-0.5]]) * stroke
        return wrist + drift * body.stature, pole

    return held


_crossed_over = _at(0.13, -0.06, -0.12, (-0.3, 0.6, -1.0), 0.01, 0.01)
_crossed_under = _at(0.115, -0.05, -0.155, (-0.3, 0.6, -1.0), 0.01, 0.01)


def _crossed(body: Body, m: Movement, side: str, since: FloatArray, trunk: FloatArray) -> _Held:
    over = side == body.handed
    return (_crossed_over if over else _crossed_under)(body, m, side, since, trunk)


_ARMS: dict[str, Callable[[Body, Movement, str, FloatArray, FloatArray], _Held]] = {
    "wave": _raised,
    "raise": _raised,
    "handshake": _handshake,
    "hug": _hug,
    "talk": _talk,
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
