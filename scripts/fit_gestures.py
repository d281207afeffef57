"""Fit how much each kind of evidence counts for a gesture, to simulated bodies.

    python scripts/fit_gestures.py [--people N] [--seed N]

Draws people who salute, do something else or nothing before a robot (`kendon.simulation.movers`),
seen by sensors from good to bad, and fits one logistic regression a gesture to the evidence that
`GestureDetector` finds in each 0.2 s. Prints the table of `kendon/features/gestures/weights.py`.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from kendon.features.gestures import GestureDetector
from kendon.features.gestures.weights import Weights
from kendon.features.track import watch
from kendon.person import FloatArray, Track
from kendon.simulation.movements import MOVEMENTS
from kendon.simulation.movers import Performance, draw_mover
from kendon.simulation.sensors import draw_sensor

#: Which movements of `kendon.simulation.movements` each gesture is made of.
MADE_OF = {
    "wave": ("wave", "raise"),
    "handshake": ("handshake", "hug"),
    "nod": ("nod", "toss"),
    "dip": ("dip",),
    "bow": ("bow",),
}
#: So much does somebody count who does something else than salute. Every second person drawn
#: telephones, points or combs their hair, to learn what that looks like; of those who walk up to
#: a robot fewer do.
SOMETHING_ELSE = 0.3
#: Joints of a depth camera are off by up to so much [m].
JOINT_NOISE = 0.04
#: How strongly a weight is drawn to `USUAL`, as the evidence is written for a weight below 1.
PULL, USUAL = 0.01, 0.6


def blur(track: Track, rng: np.random.Generator) -> Track:
    """The track as some sensor sees it; one in four is seen as it is."""
    if rng.random() < 0.25:
        return track
    seen = draw_sensor(rng).see(track, rng)
    if rng.random() < 0.5:
        return seen
    noise = rng.uniform(0.0, JOINT_NOISE)
    joints = {name: points + rng.normal(0, noise, points.shape) for name, points in seen.joints.items()}
    return replace(seen, joints=joints)


def examples(
    people: Sequence[tuple[Performance, Track]],
) -> dict[str, tuple[FloatArray, FloatArray, FloatArray]]:
    """Of each gesture the evidence, whether it was performed, and how much the row counts."""
    rows: dict[str, list[tuple[Sequence[float], bool, float]]] = {name: [] for name in MADE_OF}
    for person, track in people:
        salutes = track.name in MOVEMENTS and MOVEMENTS[track.name].gesture
        counts = 1.0 if salutes or track.name not in MOVEMENTS else SOMETHING_ELSE
        detector = GestureDetector()
        for question, middle in watch(track, detector):
            found = detector.evidence(*question)
            done = [m for m in person.movements if m.begin <= middle < m.end]
            for side, hand in zip("lr", found.hands, strict=True):
                if hand:
                    for name, evidence in zip(("wave", "handshake"), hand, strict=True):
                        does = any(m.kind in MADE_OF[name] and side in m.hands for m in done)
                        rows[name].append((evidence, does, counts))
            for name in ("nod", "dip", "bow"):
                evidence = getattr(found, name)
                if evidence:
                    rows[name].append((evidence, any(m.kind in MADE_OF[name] for m in done), counts))
    return {
        name: (
            np.nan_to_num(np.array([row[0] for row in of])),
            np.array([row[1] for row in of], dtype=float),
            np.array([row[2] for row in of]),
        )
        for name, of in rows.items()
    }


def fit(evidence: FloatArray, does: FloatArray, counts: FloatArray) -> tuple[float, ...]:
    """Log odds and weights of a logistic regression; no evidence may count the wrong way round."""
    share = counts / counts.sum()

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
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--people", type=int, default=4000, metavar="N", help="how many are drawn")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    people = []
    for _ in range(arguments.people):
        person = draw_mover(rng)
        people.append((person, blur(person.track, rng)))
    fitted = {name: fit(*of) for name, of in examples(people).items()}
    print("WEIGHTS = Weights(")
    for name in Weights._fields:
        print(f"    {name}={fitted[name]},")
    print(")")


if __name__ == "__main__":
    main()
