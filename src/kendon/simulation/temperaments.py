"""How people differ in greeting a robot: what they expect of it, and how long they wait."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from kendon.errors import UnknownNameError


@dataclass(frozen=True)
class Temperament:
    """One way to greet. Odds and times are ours where no source is named."""

    name: str
    title: str
    greets: bool = True
    speed: float = 1.2  # [m/s] (thesis 3.4)
    sighting: float = 0.8  # [s], how long they stand and look before they set off
    salutes: float = 0.6  # the odds of a distance salutation (18 of 33, thesis table 3.2)
    dips: float = 0.5  # the odds of a head dip after one on the way (thesis 2.1.3)
    waits: bool = False  # stand until the salutation is answered
    again: bool = False  # salute once more if it is not
    patience: float = 3.0  # [s], how long they wait for an answer, and hold out a hand
    stop: float = 1.1  # [m] from the robot, where they stop
    comfort: float = 0.8  # [m], nearer than this the robot may not come before the handshake
    fright: float = math.inf  # [m/s], a robot that comes faster within 2 m is backed away from
    aversion: float = 0.6  # [rad], how far the look is averted on the way; 0 = it is not
    smile: float = 2.2  # [0-5], in salutations
    turns_at: float = math.nan  # the share of the way after which they change their mind
    pauses: float = 0.0  # the odds of a halt on the way


TEMPERAMENTS: dict[str, Temperament] = {
    t.name: t
    for t in (
        Temperament(
            "eager", "salutes, comes and shakes hands", speed=1.35, salutes=0.85, again=True,
            patience=4.0, stop=1.0, smile=3.0, sighting=0.6, aversion=0.3,
        ),
        Temperament(
            "shy", "waits to be answered, keeps its distance", speed=0.95, salutes=0.6, waits=True,
            patience=3.0, stop=1.3, comfort=1.0, fright=0.6, smile=1.6, sighting=1.4, aversion=0.8,
        ),
        Temperament(
            "hurried", "in a hurry: waits for nothing long", speed=1.6, salutes=0.4, dips=0.3,
            patience=1.5, stop=1.1, sighting=0.4,
        ),
        Temperament(
            "curious", "comes slowly, halts and looks", speed=0.9, salutes=0.5, patience=6.0,
            stop=1.05, sighting=1.6, aversion=0.0, pauses=0.6,
        ),
        Temperament("ignoring", "walks past, and greets nobody", greets=False, speed=1.3),
        Temperament(
            "fickle", "changes their mind half-way", speed=1.15, salutes=0.5, turns_at=0.5,
        ),
    )
}  # fmt: skip
#: How often each is met among those who greet; ours.
_ODDS = {"eager": 0.3, "shy": 0.22, "hurried": 0.18, "curious": 0.2, "fickle": 0.1}


def temperament(name: str) -> Temperament:
    """The temperament of a name.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in TEMPERAMENTS:
        raise UnknownNameError("temperament", name, TEMPERAMENTS)
    return TEMPERAMENTS[name]


def draw_temperament(rng: np.random.Generator) -> Temperament:
    """Somebody who means to greet; numbers vary from person to person."""
    kind = TEMPERAMENTS[str(rng.choice(list(_ODDS), p=list(_ODDS.values())))]
    return replace(
        kind,
        speed=float(np.clip(kind.speed * rng.normal(1, 0.1), 0.6, 1.9)),
        sighting=float(np.clip(kind.sighting * rng.gamma(9, 1 / 9), 0.3, 2.5)),
        patience=kind.patience * float(rng.uniform(0.8, 1.2)),
        stop=float(np.clip(kind.stop * rng.normal(1, 0.07), 0.9, 1.5)),
        aversion=kind.aversion * float(rng.uniform(0.6, 1.3)),
        smile=float(np.clip(kind.smile * rng.normal(1, 0.2), 0.5, 5.0)),
        turns_at=kind.turns_at * float(rng.uniform(0.7, 1.4)),
    )
