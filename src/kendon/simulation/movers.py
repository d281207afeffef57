"""Labelled tracks of people who move: to fit and to try gesture detectors on.

Each person stands, walks up, walks past or turns before a robot at the origin, looks at it or
elsewhere, and performs one movement or none, some a head dip after it. All ranges are ours: wide,
so that what holds here holds for people elsewhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kendon.errors import ParameterError
from kendon.person import GESTURES, FloatArray, Track
from kendon.simulation.body import Body, draw_walker
from kendon.simulation.limbs import min_jerk
from kendon.simulation.motion import count_steps, look_along, move
from kendon.simulation.movements import MOVEMENTS, Movement, draw_movement, draw_talk

#: What cameras and motion capture deliver [frames a second].
RATES = (10.0, 60.0)
#: Drawn twice as often as other salutations, four times as often as other movements.
_OFTEN = ("wave", "handshake", "dip", "nod", "toss", "talk")
#: Every second person's head dips after a distance salutation (thesis 2.1.3), so soon [s].
_DIPS, _SOON = 0.5, (0.1, 1.0)
#: How often each is done near the robot, where not in three of ten: people talk near to each
#: other, and hold up a hand to those who are far.
_NEAR = {
    "talk": 0.95, "offer": 0.95, "call": 0.5, "face": 0.5, "hair": 0.5, "wave": 0.15, "raise": 0.1,
}  # fmt: skip
#: Who closes in stands so far away, and who embraces [m].
_CLOSE, _EMBRACE = (0.7, 1.4), (0.35, 0.7)
#: So many swing their arms like joggers.
_BRISK = 0.35
_ROBOT_FACE = (0.0, 0.0, 1.2)
#: Heads turn by so much from the body's heading before the body turns, too [rad].
_MOST_TURNED = math.radians(75)


@dataclass(frozen=True, eq=False)
class Performance:
    """A track with what truly happened; its own gestures are unknown, for detectors to find."""

    track: Track  # named by the movement
    truth: FloatArray  # (T, 3), 0 or 1, in the order of kendon.person.GESTURES
    movements: tuple[Movement, ...]  # in order; those without a gesture are there to confuse
    body: Body


def truth_of(t: FloatArray, movements: tuple[Movement, ...]) -> FloatArray:
    """Which gestures movements show at times t, from the first stir to the last; (T, 3)."""
    truth = np.zeros((len(t), len(GESTURES)))
    for m in movements:
        if m.gesture:
            truth[(t >= m.begin) & (t < m.end), GESTURES.index(m.gesture)] = 1.0
    return truth


def draw_mover(rng: np.random.Generator, rate: float | None = None) -> Performance:
    """Somebody who performs a movement drawn from all of them, or none at all."""
    kinds = (*MOVEMENTS, "")
    # Waves and handshakes are the most usual salutations, and talk is what else people do most;
    # movements of the head are the shortest: there would be little to see of them.
    odds = np.array([6.0 if k in _OFTEN else 3.0 if MOVEMENTS[k].gesture else 1.5
                     for k in MOVEMENTS] + [9.0])  # fmt: skip
    return perform_movement(str(rng.choice(kinds, p=odds / odds.sum())), rng, rate)


def perform_movement(
    kind: str, rng: np.random.Generator, rate: float | None = None, body: Body | None = None
) -> Performance:
    """Somebody who performs a movement of a kind.

    Args:
        kind: one of `kendon.simulation.movements.MOVEMENTS`, or "" for none.
        rng: chance.
        rate: frames a second; drawn from `RATES` unless given.
        body: whose; drawn unless given.

    Raises:
        UnknownNameError: there is no such kind.
        ParameterError: the rate is not a positive number.
    """
    rate = float(np.exp(rng.uniform(*np.log(RATES)))) if rate is None else rate
    if not 0 < rate < math.inf:
        raise ParameterError(f"frames a second must be positive, not {rate}")
    body = body or draw_walker(rng, _BRISK)
    closes = kind in ("handshake", "hug")
    near = closes or (kind in MOVEMENTS and rng.random() < _NEAR.get(kind, 0.3))
    drawn: list[Movement] = []
    begin = float(rng.uniform(0.5, 3.0))
    if rng.random() < 0.25:  # something else before
        other = str(rng.choice([k for k in MOVEMENTS if not MOVEMENTS[k].gesture]))
        drawn.append(draw_movement(other, rng, begin=begin, handed=body.handed))
        begin = drawn[-1].end + float(rng.uniform(0.1, 1.0))
    salutes_at = begin
    if kind == "talk":
        drawn += draw_talk(rng, begin=begin, handed=body.handed)
        begin = max(m.end for m in drawn)
    elif kind:
        drawn.append(draw_movement(kind, rng, begin=begin, handed=body.handed, near=near))
        begin = drawn[-1].end
        if drawn[-1].gesture == "dsal" and rng.random() < _DIPS:
            later = begin + float(rng.uniform(*_SOON))
            drawn.append(draw_movement("dip", rng, begin=later, handed=body.handed))
            begin = drawn[-1].end
    t = np.arange(0.0, begin + rng.uniform(0.5, 3.0), 1 / rate)
    t = t + rng.uniform(0, 0.2 / rate, len(t))  # stamps jitter
    stop = rng.uniform(*(_EMBRACE if kind == "hug" else _CLOSE if near else (1.8, 6.0)))
    speed, way, aside, heading = _way(rng, t, salutes_at, float(stop), near, closes)
    # As if the person came along x; turned to where they do come from.
    bearing = float(rng.uniform(-0.7, 0.7))
    c, s = math.cos(bearing), math.sin(bearing)
    ground, heading = (
        np.stack([c * way - s * aside, s * way + c * aside], axis=1),
        heading + bearing,
    )
    salutes = [m for m in drawn if m.gesture and m.gesture != "hdip"]
    look = _look(rng, t, ground, heading, body, salutes)
    motion = move(body, t, ground, heading, look, speed, count_steps(body, t, speed), drawn)
    track = Track.build(
        t,
        motion.head,
        head_rotation=motion.head_rotation,
        joints=motion.joints,
        name=kind or "none",
    )
    return Performance(track, truth_of(t, tuple(drawn)), tuple(drawn), body)


def _way(
    rng: np.random.Generator, t: FloatArray, salutes: float, stop: float, near: bool, closes: bool
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Speed, x and y before a robot that looks along x, and heading of the body over time."""
    walks = rng.random() < (0.5 if near else 0.65)
    heading, straight = np.full(len(t), math.pi), np.zeros(len(t))
    cruise = float(rng.uniform(0.6, 1.6))
    setting_off = float(rng.uniform(0.4, 0.9))
    if not walks:
        # Who stands may be turned away, and may turn.
        turned = float(rng.normal(0, 0.15 if closes else 0.5))
        if rng.random() < 0.3 and not closes:
            begin, seconds = rng.uniform(0, t[-1]), rng.uniform(0.7, 1.5)
            heading += (1 - min_jerk((t - begin) / seconds)) * rng.uniform(-1.2, 1.2)
        return straight, straight + stop, straight, heading + turned
    if near:
        # Walk up, stop, salute.
        ends = salutes + rng.uniform(-0.3, 0.1)
        speed = cruise * min_jerk((ends - t) / setting_off)
        way = _integral(t, speed)
        return speed, stop + way[-1] - way, straight, heading
    begins = float(rng.choice([-1.0, rng.uniform(0, t[-1])]))
    speed = cruise * min_jerk((t - begins) / setting_off)
    way = _integral(t, speed)
    if rng.random() < 0.3:
        # Past the robot, not to it.
        side = float(rng.choice([-1.0, 1.0]))
        along = side * (way - way[-1] / 2)
        return speed, straight + stop, along, heading - side * math.pi / 2
    return speed, stop + way[-1] - way, straight, heading


def _integral(t: FloatArray, speed: FloatArray) -> FloatArray:
    return np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(t))])


def _look(
    rng: np.random.Generator, t: FloatArray, ground: FloatArray, heading: FloatArray, body: Body,
    salutes: list[Movement],
) -> FloatArray:  # fmt: skip
    """At the robot's face, aside, down or ahead in turns; as a rule at the robot in salutations."""
    height = body.face[1] + body.neck + body.torso + body.hip_height
    dx, dy, dz = (
        _ROBOT_FACE[0] - ground[:, 0],
        _ROBOT_FACE[1] - ground[:, 1],
        _ROBOT_FACE[2] - height,
    )
    aside = np.angle(np.exp(1j * (np.arctan2(dy, dx) - heading)))
    down = np.arctan2(-dz, np.hypot(dx, dy))
    shares = np.zeros((3, len(t)))  # of looking at the robot; the yaw and pitch of another look
    begin = -1.0
    while begin < t[-1]:
        at_robot = float(rng.random() < 0.5)
        other = rng.uniform(-1.1, 1.1), math.radians(rng.choice([0.0, rng.uniform(10, 45)]))
        new = np.array([[at_robot], [other[0]], [other[1]]])
        shares += (new - shares) * min_jerk((t - begin) / rng.uniform(0.25, 0.5))
        begin += rng.uniform(0.7, 4.0)
    for m in salutes:
        if rng.random() < 0.9:
            shown = min_jerk((t - m.begin + 0.4) / 0.4) * min_jerk((m.end + 0.4 - t) / 0.4)
            shares[0] += (1 - shares[0]) * shown
    yaw = shares[0] * aside + (1 - shares[0]) * shares[1]
    pitch = shares[0] * down + (1 - shares[0]) * shares[2]
    # Heads are never quite still, nor do noses point exactly at what eyes look at.
    turns, starts = rng.uniform(1, 6, (2, 3, 1)), rng.uniform(0, 2 * math.pi, (2, 3, 1))
    wander = np.sin(turns * t + starts).sum(axis=1) * 0.02 + rng.normal(0, 0.08, (2, 1))
    yaw = _MOST_TURNED * np.tanh((yaw + wander[0]) / _MOST_TURNED)
    return look_along(heading + yaw, pitch + wander[1])
