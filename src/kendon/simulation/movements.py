"""What people do with their heads, trunks and arms: salutations, and what only looks like them.

A movement is a handful of numbers; `kendon.simulation.postures` turns them into angles. Which
of the thesis's gestures (3.3.5) it is to be taken for says `Movement.gesture`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from kendon.errors import ParameterError, UnknownNameError
from kendon.person import GESTURES

#: The peak of a min-jerk movement's speed over its mean (Flash & Hogan 1985).
_PEAK = 1.875
#: The fastest that heads and trunks bend in everyday life [rad/s]; ours, about half of what
#: people can do.
_FASTEST = {
    "dip": math.radians(400),
    "nod": math.radians(400),
    "toss": math.radians(300),
    "bow": math.radians(180),
}


@dataclass(frozen=True)
class Movement:
    """One movement. What `size`, `height` and `aside` mean depends on its kind (see `MOVEMENTS`).

    Raises:
        ParameterError: a time, rate or gesture is impossible.
        UnknownNameError: there is no such kind.
    """

    kind: str
    begin: float  # [s]
    duration: float  # [s], with rise and fall
    rise: float = 0.5  # [s], from rest into the posture
    fall: float = 0.5  # [s], out of it
    hands: str = ""  # "l", "r" or "lr"
    size: float = 0.0  # [rad] of a head or trunk, [m] of a hand's path from end to end
    rate: float = 0.0  # [1/s], strokes a second
    height: float = 0.0  # of the hand
    aside: float = 0.0  # of the hand
    lean: float = 0.0  # [rad], of the trunk with it
    wait: float = 0.0  # [s], how long a hand is held out before it is taken
    gesture: str = ""  # "dsal", "csal", "hdip", or "" = none

    def __post_init__(self) -> None:
        if self.kind not in MOVEMENTS:
            raise UnknownNameError("movement", self.kind, MOVEMENTS)
        if self.gesture not in ("", *GESTURES):
            raise UnknownNameError("gesture", self.gesture, GESTURES)
        times = (self.rise, self.fall, self.duration - self.rise - self.fall + 1e-9)
        if not (all(0 < x < math.inf for x in times) and math.isfinite(self.begin)):
            raise ParameterError(
                f"a movement begins at a finite time and lasts at least its rise and fall, both"
                f" positive: not from {self.begin} for {self.duration} s with a rise of"
                f" {self.rise} and a fall of {self.fall} s"
            )
        if not 0 <= self.rate < math.inf:
            raise ParameterError(f"a movement's rate is not negative and finite, not {self.rate}")
        if set(self.hands) - set("lr"):
            raise ParameterError(f"a movement's hands are l, r or lr, not {self.hands!r}")

    @property
    def end(self) -> float:
        """When it is over [s]."""
        return self.begin + self.duration


@dataclass(frozen=True)
class Kind:
    """What there is to know of one kind of movement."""

    gesture: str  # what it is taken for; a distance salutation shown near is a close one
    draw: Callable[[np.random.Generator, str], Movement]  # one of its kind by the preferred hand


def draw_movement(
    kind: str,
    rng: np.random.Generator,
    *,
    begin: float = 0.0,
    handed: str = "r",
    near: bool = False,
) -> Movement:
    """Draw a movement of a kind.

    Args:
        kind: one of `MOVEMENTS`.
        rng: chance.
        begin: when it begins [s].
        handed: the hand the person prefers.
        near: whether it is shown at close range, where a salutation is a close one.

    Raises:
        UnknownNameError: there is no such kind.
    """
    if kind not in MOVEMENTS:
        raise UnknownNameError("movement", kind, MOVEMENTS)
    drawn = MOVEMENTS[kind].draw(rng, handed)
    gesture = MOVEMENTS[kind].gesture
    if near and gesture == "dsal":
        gesture = "csal"
    return replace(drawn, begin=begin, gesture=gesture)


def lasting(movement: Movement, seconds: float) -> Movement:
    """The same movement in another time: with fewer or more strokes, held shorter or longer.

    Arms keep the time they need to rise and fall, so theirs may last longer than asked; heads and
    trunks hurry, and bend less deep where they would otherwise move too fast.
    """
    m = movement
    if m.hands:
        least = m.rise + m.fall + (1 / m.rate if m.rate else 0.1)
        duration = max(seconds, least)
        # The strokes come first; half of what time is left may be waited.
        spare = duration - least
        return replace(m, duration=duration, wait=min(m.wait, spare / 2))
    # A head is tossed and a trunk bowed once, however much time there is.
    duration = min(seconds, m.duration) if m.kind in ("toss", "bow") else seconds
    hurry = min(1.0, duration / (m.rise + m.fall))
    rise, fall = m.rise * hurry, m.fall * hurry
    size = min(m.size, _FASTEST[m.kind] / _PEAK * min(rise, fall))
    return replace(m, duration=duration, rise=rise, fall=fall, size=size)


def shown(movement: Movement, begin: float, seconds: float = math.nan) -> Movement:
    """The same movement, plainly shown from a time on [s], for so long, or for its own time.

    Who watches sees a salutation begin and end when it is on its way: the arm half raised, the
    head or the trunk half bent.
    """
    if seconds == seconds:
        ways = (movement.rise + movement.fall) / 2
        # A head that has little time is half bent for half of it.
        movement = lasting(movement, seconds + (ways if movement.hands else min(ways, seconds)))
    return replace(movement, begin=begin - movement.rise / 2)


def _other(hand: str) -> str:
    return "l" if hand == "r" else "r"


def _hand(rng: np.random.Generator, handed: str, both: float = 0.0) -> str:
    """One hand, the preferred in four of five; both in some."""
    if rng.random() < both:
        return "lr"
    return handed if rng.random() < 0.8 else _other(handed)


def _wave(rng: np.random.Generator, handed: str) -> Movement:
    """Height 0 is a hand at the shoulder, 1 an arm overhead; 1 to 3 strokes a second."""
    height = float(rng.beta(1.2, 1.5))
    rate = float(rng.uniform(1.0, 3.0))
    # Faster strokes are shorter; a raised arm swings wider.
    size = float(rng.uniform(0.10, 0.20) * (1 + height) * min(1.0, 1.8 / rate))
    strokes = float(rng.integers(1, 7))
    rise, fall = ((0.45 + 0.3 * height) * rng.uniform(0.95, 1.5, 2)).tolist()
    return Movement(
        "wave", 0.0, rise + strokes / rate + fall, rise, fall,
        hands=_hand(rng, handed, 0.06), size=size, rate=rate,
        height=height, aside=float(rng.uniform(-0.5, 1.0)),
    )  # fmt: skip


def _raise(rng: np.random.Generator, handed: str) -> Movement:
    """A hand raised once, held and lowered: hi."""
    height = float(rng.beta(1.2, 2.0))
    rise, fall = ((0.45 + 0.3 * height) * rng.uniform(0.95, 1.5, 2)).tolist()
    hold = float(rng.uniform(0.15, 1.2))
    return Movement(
        "raise", 0.0, rise + hold + fall, rise, fall,
        hands=_hand(rng, handed, 0.06), height=height, aside=float(rng.uniform(-0.5, 1.0)),
    )  # fmt: skip


def _nod(rng: np.random.Generator, handed: str) -> Movement:
    """Small pitches, 2 to 4 a second (Hadar et al. 1983)."""
    rate = float(rng.uniform(2.0, 4.0))
    strokes = float(rng.integers(1, 5))
    size = math.radians(rng.uniform(6, 18)) * min(1.0, 2.5 / rate)
    quarter = 0.25 / rate
    return Movement("nod", 0.0, strokes / rate, quarter, quarter, size=size, rate=rate)


def _toss(rng: np.random.Generator, handed: str) -> Movement:
    """The head thrown back for a moment."""
    rise, fall = float(rng.uniform(0.15, 0.28)), float(rng.uniform(0.25, 0.5))
    hold = float(rng.uniform(0.0, 0.25))
    size = math.radians(rng.uniform(8, 20))
    return Movement("toss", 0.0, rise + hold + fall, rise, fall, size=size)


def _dip(rng: np.random.Generator, handed: str) -> Movement:
    """The head bent forward at the neck, 0.3 to 0.9 s (2.1.3, 3.4)."""
    duration = float(rng.uniform(0.3, 0.9))
    rise = duration * float(rng.uniform(0.35, 0.5))
    fall = (duration - rise) * float(rng.uniform(0.7, 1.0))
    size = min(math.radians(rng.uniform(25, 60)), _FASTEST["dip"] / _PEAK * min(rise, fall))
    return Movement("dip", 0.0, duration, rise, fall, size=size)


def _bow(rng: np.random.Generator, handed: str) -> Movement:
    """The trunk bent at the hips by 10 to 60 degrees, 0.8 to 2 s."""
    duration = float(rng.uniform(0.8, 2.0))
    rise = duration * float(rng.uniform(0.3, 0.42))
    fall = duration * float(rng.uniform(0.35, 0.5))
    size = math.radians(rng.uniform(10, 60))
    size = min(size, _FASTEST["bow"] / _PEAK * min(rise, fall))
    return Movement("bow", 0.0, duration, rise, fall, size=size)


def _handshake(rng: np.random.Generator, handed: str) -> Movement:
    """A hand held out [m above the floor], taken, and shaken 3 to 10 cm up and down.

    The right hand, whichever is preferred, but for one person in fifty; one in ten clasps the
    other's hand with both.
    """
    rise, fall = rng.uniform(0.5, 0.9, 2).tolist()
    wait = float(rng.choice([0.0, rng.uniform(0.2, 2.0)]))
    rate = float(rng.uniform(2.0, 4.0))
    # The thesis (2.1.6): three up-down movements as a rule.
    strokes = max(2.0, round(rng.uniform(1.0, 2.2) * rate))
    both = rng.spawn(1)[0]  # what else is drawn here does not depend on it
    hands, aside = "l" if rng.random() < 0.02 else "r", float(rng.uniform(-0.6, 0.1))
    if both.random() < 0.1:
        hands, aside = "lr", float(both.uniform(-1.0, -0.8))  # they meet before the middle
    return Movement(
        "handshake", 0.0, rise + wait + strokes / rate + fall, rise, fall,
        hands=hands, size=float(rng.uniform(0.03, 0.10)),
        rate=rate, height=float(rng.uniform(0.97, 1.13)), aside=aside,
        lean=math.radians(rng.uniform(0, 12)), wait=wait,
    )  # fmt: skip


def _hug(rng: np.random.Generator, handed: str) -> Movement:
    """Both arms reached out, open, then closed about somebody; height at the shoulders = 0."""
    rise, fall = rng.uniform(0.6, 1.0, 2).tolist()
    return Movement(
        "hug", 0.0, rise + rng.uniform(0.8, 3.0) + fall, rise, fall,
        hands="lr", size=float(rng.uniform(0.2, 0.5)), height=float(rng.uniform(-0.15, 0.15)),
        lean=math.radians(rng.uniform(3, 15)),
    )  # fmt: skip


def _talk(rng: np.random.Generator, handed: str) -> Movement:
    """Beats: small strokes of hands held before the belly, some before the chest.

    One in five is made beside the head: the upper periphery of gesture space (McNeill 1992).
    """
    high = rng.random() < 0.2
    return _held(
        "talk", rng, rng.choice([handed, "lr"]), rate=rng.uniform(0.6, 2.2),
        size=rng.uniform(0.04, 0.2), aside=rng.uniform(0, 6),
        height=rng.uniform(2.0, 5.0) if high else rng.uniform(-0.6, 2.0),
    )  # fmt: skip


def _offer(rng: np.random.Generator, handed: str) -> Movement:
    """An open hand, or both, held out to the partner and taken back: what is said is presented.

    The conduit of McNeill (1992), the open hand supine of Kendon (2004). Size is how far the hand
    goes out from the shoulder [m], height the arm's elevation, aside its azimuth outward [rad].
    """
    rise, fall = rng.uniform(0.3, 0.7, 2).tolist()
    hold = float(rng.uniform(0.1, 0.9))
    return Movement(
        "offer", 0.0, rise + hold + fall, rise, fall, hands=str(rng.choice([handed, "lr"])),
        size=float(rng.uniform(0.25, 0.52)), height=math.radians(rng.uniform(-50, 0)),
        aside=math.radians(rng.uniform(-25, 40)),
    )  # fmt: skip


def draw_talk(rng: np.random.Generator, *, begin: float, handed: str) -> list[Movement]:
    """A turn at talk: phrases of gesture one after another, with rests between (McNeill 1992).

    Hands rest beside the trunk, or before the belly all the while. The times are ours.

    Args:
        rng: chance.
        begin: when it begins [s].
        handed: the hand the person prefers.
    """
    phrases: list[Movement] = []
    t, end = begin, begin + float(rng.uniform(2.0, 14.0))
    while t < end:
        kind = "talk" if rng.random() < 0.6 else "offer"
        phrase = draw_movement(kind, rng, begin=t, handed=handed)
        if kind == "talk":
            phrase = lasting(phrase, float(rng.uniform(0.8, 5.0)))
        phrases.append(phrase)
        # A hand goes on to the next phrase while it falls, or rests for a while.
        t = phrase.end + float(rng.choice([-0.5 * phrase.fall, rng.uniform(0.0, 2.5)]))
    if rng.random() < 0.4:
        belly = replace(_talk(rng, handed), height=float(rng.uniform(-0.6, 0.3)), size=0.03)
        seconds = max(phrases[-1].end + 0.5 - begin, 2.5)
        phrases.insert(0, replace(belly, begin=begin, duration=seconds))
    return phrases


def _point(rng: np.random.Generator, handed: str) -> Movement:
    """An arm stretched out; height is its elevation, aside its azimuth outward [rad]."""
    return _held(
        "point", rng, _hand(rng, handed), shortest=1.0, longest=2.5,
        height=math.radians(rng.uniform(-25, 20)), aside=math.radians(rng.uniform(-20, 80)),
    )  # fmt: skip


def _watch(rng: np.random.Generator, handed: str) -> Movement:
    return _held(
        "watch", rng, _other(handed), shortest=1.2, longest=2.5,
        size=math.radians(rng.uniform(15, 40)),
    )  # fmt: skip


def _of(kind: str, both: float = 0.0, longest: float = 8.0) -> Callable[..., Movement]:
    """What is held for a while; height and aside vary the posture.

    Who reads bends the head; who scratches their face or smooths their hair moves the hand there.
    """

    def draw(rng: np.random.Generator, handed: str) -> Movement:
        size = math.radians(rng.uniform(15, 40)) if kind == "text" else 0.0
        rate = 0.0
        if kind in ("face", "hair") and rng.random() < 0.7:
            size, rate = rng.uniform(0.02, 0.15), rng.uniform(0.5, 2.5)
        return _held(kind, rng, _hand(rng, handed, both), longest=longest, size=size, rate=rate,
                     height=rng.uniform(-1, 1), aside=rng.uniform(-1, 1))  # fmt: skip

    return draw


def _held(
    kind: str, rng: np.random.Generator, hands: str, *, shortest: float = 1.5,
    longest: float = 8.0, size: float = 0.0, rate: float = 0.0, height: float = 0.0,
    aside: float = 0.0,
) -> Movement:  # fmt: skip
    rise, fall = rng.uniform(0.6, 1.1, 2).tolist()
    duration = max(rise + fall + 0.2, rng.uniform(shortest, longest))
    return Movement(
        kind, 0.0, float(duration), rise, fall, hands=str(hands), size=float(size),
        rate=float(rate), height=float(height), aside=float(aside),
    )  # fmt: skip


#: Every kind of movement by name; first the salutations, then what is none.
MOVEMENTS: dict[str, Kind] = {
    "wave": Kind("dsal", _wave),
    "raise": Kind("dsal", _raise),
    "nod": Kind("dsal", _nod),
    "toss": Kind("dsal", _toss),
    "bow": Kind("dsal", _bow),
    "handshake": Kind("csal", _handshake),
    "hug": Kind("csal", _hug),
    "dip": Kind("hdip", _dip),
    "talk": Kind("", _talk),
    "offer": Kind("", _offer),
    "point": Kind("", _point),
    "watch": Kind("", _watch),
    "call": Kind("", _of("call", longest=12.0)),
    "text": Kind("", _of("text", 0.5, longest=12.0)),
    "face": Kind("", _of("face", longest=4.0)),
    "hair": Kind("", _of("hair", longest=4.0)),
    "pockets": Kind("", _of("pockets", 0.6, longest=12.0)),
    "crossed": Kind("", _of("crossed", 1.0, longest=12.0)),
    "bag": Kind("", _of("bag", longest=12.0)),
}
