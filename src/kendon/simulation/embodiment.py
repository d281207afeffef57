"""Bodies for people whose way, look and phases are already drawn."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kendon.person import FloatArray, Track
from kendon.phases import Phase
from kendon.simulation.body import FACE_HEIGHT, draw_walker
from kendon.simulation.motion import count_steps, move
from kendon.simulation.movements import Movement, draw_movement, shown

#: What people do in each salutation, and how often; ours, after what Kendon lists (2.1.2, 2.1.6).
#: In a close salutation "" is to stand and look, as those do who do not touch.
REPERTOIRE: Mapping[Phase, Mapping[str, float]] = {
    Phase.DS: {"wave": 0.5, "raise": 0.15, "nod": 0.15, "toss": 0.13, "bow": 0.07},
    Phase.HD: {"dip": 1.0},
    Phase.CS: {
        "handshake": 0.58, "hug": 0.12, "bow": 0.08, "wave": 0.06, "raise": 0.04, "nod": 0.06,
        "": 0.06,
    },
}  # fmt: skip
#: What people may be at when nothing is asked of them, and how often they are; ours.
PASTIMES = ("pockets", "bag", "text", "call", "face", "hair", "watch", "crossed")
BUSY = 0.3
#: So many of those who walk up to somebody swing their arms like joggers; ours. Among movers, who
#: are there to confuse detectors, there are more.
_BRISK = 0.2


class Salutation(NamedTuple):
    """A phase with a movement, as labels have it."""

    phase: Phase
    begin: float  # [s]
    seconds: float


def draw_salutation(
    rng: np.random.Generator, salutation: Salutation, handed: str = "r"
) -> Movement | None:
    """A movement that shows a salutation, or None for one that only stands and looks.

    Labels begin and end when it is plainly shown.
    """
    phase, begin, seconds = salutation
    kinds = REPERTOIRE[phase]
    kind = str(rng.choice(list(kinds), p=list(kinds.values())))
    if not kind:
        return None
    return shown(draw_movement(kind, rng, handed=handed, near=phase is Phase.CS), begin, seconds)


def with_body(
    rng: np.random.Generator,
    track: Track,
    ground: FloatArray,
    heading: FloatArray,
    height: float,
    salutations: Sequence[Salutation] = (),
) -> Track:
    """Give a body to somebody whose way and look are drawn: joints, and a head that moves.

    Args:
        rng: chance.
        track: the person; of its head only the rotation stays, but for the movements.
        ground: under the face of a person who stands upright [m], (T, 2).
        heading: of the body [rad], (T,).
        height: of the face [m].
        salutations: what they show, in order.
    """
    body = draw_walker(rng, _BRISK, stature=height / FACE_HEIGHT)
    drawn = [draw_salutation(rng, s, body.handed) for s in salutations]
    movements = [m for m in drawn if m is not None]
    t = track.t
    if rng.random() < BUSY:
        pastime = draw_movement(str(rng.choice(PASTIMES)), rng, handed=body.handed)
        begin = float(rng.uniform(-pastime.duration, t[-1]))
        # Whoever salutes has put the telephone away.
        free = min((m.begin for m in movements), default=math.inf)
        seconds = min(pastime.duration, free - begin)
        if seconds > pastime.rise + pastime.fall:
            movements.insert(0, replace(pastime, begin=begin, duration=seconds))
    facing = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    speed = _eased(t, np.hypot(*np.gradient(ground, t, axis=0).T))
    steps = count_steps(body, t, speed) + rng.uniform(0, 2)
    motion = move(
        body, t, ground - body.face[0] * facing, heading, track.head_rotation, speed, steps,
        movements,
    )  # fmt: skip
    return replace(
        track, head=motion.head, head_rotation=motion.head_rotation, joints=motion.joints
    )


def _eased(t: FloatArray, speed: FloatArray, seconds: float = 0.4) -> FloatArray:
    """A moving mean: limbs begin and end to swing more gently than a drawn way changes speed."""
    n = max(1, round(seconds * (len(t) - 1) / max(t[-1] - t[0], 1e-9))) if len(t) > 1 else 1
    padded = np.concatenate([np.full(n // 2, speed[0]), speed, np.full(n - 1 - n // 2, speed[-1])])
    return np.convolve(padded, np.full(n, 1 / n), mode="valid")
