"""Fit how much each kind of evidence counts for a gesture, to simulated bodies.

    python scripts/fit_gestures.py [--people N] [--seed N]

Draws people who salute, do something else or nothing before a robot (`kendon.simulation.movers`),
seen by sensors from good to bad, and fits one logistic regression a gesture to the evidence that
`GestureDetector` finds in each 0.2 s. Prints the table of `kendon/features/gestures/weights.py`.
"""

from __future__ import annotations

import argparse
import math
import textwrap
from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from kendon.features.gestures import GestureDetector
from kendon.features.gestures.weights import Weights
from kendon.features.track import watch
from kendon.person import FloatArray, Track
from kendon.simulation.movements import Movement
from kendon.simulation.movers import Performance, draw_mover
from kendon.simulation.sensors import draw_sensor

#: Which movements of `kendon.simulation.movements` each gesture is made of.
MADE_OF = {
    "wave": ("wave", "raise"),
    "handshake": ("handshake", "hug"),
    "nod": ("nod",),
    "toss": ("toss",),
    "dip": ("dip",),
    "dip_of_pitch": ("dip",),
    "bow": ("bow",),
    "bow_of_height": ("bow",),
}
#: The greetings of hands, which are no talk.
HANDS = MADE_OF["wave"] + MADE_OF["handshake"]
#: How often a gesture is seen in an interval of a greeting: how long it lasts (as drawn there)
#: times the share of greetings that have it, of the eight seconds a greeting takes. A wave 1.3 s
#: in two of three, a handshake 1.7 s in three of four, nods and tosses 0.6 s in one of six each, a
#: dip 0.6 s in every second (thesis 2.1.3), a bow 1.4 s in one of ten. A hand's share is half.
PRIORS = {
    "wave": 0.055,
    "handshake": 0.08,
    "nod": 0.0125,
    "toss": 0.0125,
    "dip": 0.04,
    "dip_of_pitch": 0.04,
    "bow": 0.02,
    "bow_of_height": 0.02,
}
#: A movement is plainly shown from this share of its rise until that share of its fall is left.
HALF = 0.5
#: What is told by going and coming back; so long after its end it is plainly to be seen, and so
#: long there are traces of it [s].
BEATS, LASTING, FADING = ("nod", "toss"), 0.3, 0.8
#: How strongly a weight is drawn to `USUAL`, as the evidence is written for a weight below 1.
PULL, USUAL = 0.005, 0.6


def blur(track: Track, rng: np.random.Generator) -> Track:
    """The track as some sensor sees it; one in four is seen as it is."""
    if rng.random() < 0.25:
        return track
    return draw_sensor(rng).see(track, rng)


def shown(movement: Movement, t: float) -> float:
    """1 while a movement is plainly shown, 0 before and after, NaN where nobody can tell.

    A nod or a toss can be told from a look down or up once the head has come back: until that, and
    a while after what shows it, it is neither.
    """
    if movement.kind in BEATS:
        first = movement.begin + (
            2 * movement.rise if movement.kind == "nod" else movement.duration - movement.fall / 2
        )
        if first <= t < movement.end + LASTING:
            return 1.0
        return math.nan if movement.begin <= t < movement.end + FADING else 0.0
    begins = movement.begin + HALF * movement.rise
    ends = movement.end - HALF * movement.fall
    return 1.0 if begins <= t < ends else 0.0


def examples(
    people: Sequence[tuple[Performance, Track]],
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Of each gesture the evidence, and whether it was performed."""
    rows: dict[str, list[tuple[Sequence[float], float]]] = {name: [] for name in MADE_OF}

    def add(name: str, evidence: Sequence[float], moves: list[Movement], t: float) -> None:
        other = [m for m in moves if m.kind in BEATS and m.kind != name]
        if name in BEATS and any(shown(m, t) != 0 for m in other):
            return  # nobody needs to tell a nod from a toss
        does = sum(shown(m, t) for m in moves if m.kind in MADE_OF[name])
        if not math.isnan(does):
            rows[name].append((evidence, does))

    for person, track in people:
        detector = GestureDetector()
        for question, t in watch(track, detector):
            found = detector.evidence(*question)
            if any(shown(m, t) == 1 for m in person.movements if m.kind in HANDS):
                detector.greeted(question.end)
            for side, hand in zip("lr", found.hands, strict=True):
                if hand:
                    moves = [m for m in person.movements if side in m.hands]
                    add("wave", hand[0], moves, t)
                    add("handshake", hand[1], moves, t)
            for name in ("nod", "toss", "dip"):
                evidence = getattr(found, name)
                if evidence:
                    add(name, evidence, list(person.movements), t)
            if found.dip and found.dip.of_pitch[0] == found.dip.of_pitch[0]:
                add("dip_of_pitch", found.dip.of_pitch, list(person.movements), t)
            if found.bow:
                if found.bow.flexion == found.bow.flexion:
                    add("bow", found.bow.of_trunk, list(person.movements), t)
                add("bow_of_height", found.bow.of_height, list(person.movements), t)
    return {
        name: (
            np.nan_to_num(np.array([row[0] for row in of])),
            np.array([row[1] for row in of]),
        )
        for name, of in rows.items()
    }


def fit(evidence: FloatArray, does: FloatArray, prior: float) -> tuple[float, ...]:
    """Log odds and weights of a logistic regression; no evidence may count the wrong way round.

    The people drawn perform a gesture more or less often than people who greet do: rows count so
    that its share is the prior.
    """
    drawn = does.mean()
    share = np.where(does > 0, prior / drawn, (1 - prior) / (1 - drawn)) / len(does)

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        odds = weights[0] + evidence @ weights[1:]
        miss = share * (1 / (1 + np.exp(-odds)) - does)
        pull = weights[1:] - USUAL
        value = share @ (np.logaddexp(0, odds) - does * odds) + PULL * pull @ pull
        return float(value), np.concatenate([[miss.sum()], miss @ evidence + 2 * PULL * pull])

    kinds = evidence.shape[1]
    start = np.concatenate([[-3.0], np.full(kinds, USUAL)])
    bounds = [(None, None)] + [(0.0, None)] * kinds
    found = minimize(loss, start, jac=True, method="L-BFGS-B", bounds=bounds)
    return tuple(round(float(weight), 2) for weight in found.x)


def main() -> None:
    """Draw, fit and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--people", type=int, default=2500, metavar="N", help="how many are drawn")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    people = []
    for _ in range(arguments.people):
        person = draw_mover(rng)
        people.append((person, blur(person.track, rng)))
    fitted = {name: fit(*of, PRIORS[name]) for name, of in examples(people).items()}
    print("WEIGHTS = Weights(")
    for name in Weights._fields:
        row = f"{name}={fitted[name]},"
        print(textwrap.fill(row, 95, initial_indent="    ", subsequent_indent="        "))
    print(")  # fmt: skip")


if __name__ == "__main__":
    main()
