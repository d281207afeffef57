"""How measurements speak for or against a gesture.

Each measurement is weighed as evidence: positive speaks for the gesture, negative against it, 0
says nothing. It grows in proportion to how far the measurement lies from the value at which it is
undecided, as the log likelihood ratio of two normal distributions of equal spread does, and it is
limited, as no single measurement is beyond doubt. Noise in the measurement widens both
distributions, so that evidence from bad input fades to nothing and the probability to its prior.
What is unknown says nothing.

Evidence of one gesture overlaps: a hand that is up is mostly up for a while. A logistic
regression on simulated bodies tells how much each counts beside the others
(`kendon.features.gestures.weights`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

#: The two distributions lie so many scales apart, by which their own variance is that many scales
#: squared (the log likelihood ratio grows with their distance over their variance).
APART = 6.0


class Weighing(NamedTuple):
    """How one kind of measurement becomes evidence."""

    even: float  # the value that says nothing, in the measurement's unit
    scale: float  # so far from there the evidence is 1; negative where less speaks for the gesture
    least: float  # limits of the evidence
    most: float

    def evidence(self, value: float, noise: float = 0.0) -> float:
        """The evidence of a measurement; NaN where it is unknown.

        Args:
            value: the measurement.
            noise: its standard deviation, in the same unit.
        """
        share = noise / self.scale
        ratio = (value - self.even) / self.scale / (1.0 + share * share / APART)
        if ratio > self.most:
            return self.most
        return self.least if ratio < self.least else ratio  # NaN stays NaN


def posterior(evidence: Sequence[float], weights: Sequence[float]) -> float:
    """The probability of a gesture.

    Args:
        evidence: of each kind of measurement; NaN where it is unknown.
        weights: the log odds without evidence, then the weight of each kind.

    Returns:
        NaN where nothing is known.
    """
    odds, known = weights[0], False
    for value, weight in zip(evidence, weights[1:], strict=True):
        if value == value:  # NaN is unequal to itself
            odds += weight * value
            known = True
    return logistic(odds) if known else math.nan


def logistic(odds: float) -> float:
    """The probability of log odds."""
    if odds < -700.0:  # its exponential is past floating point
        return 0.0
    return 1.0 / (1.0 + math.exp(-odds))


def surer(*probabilities: float) -> float:
    """That one of things is so which mostly go together; of the known ones; NaN if none is known.

    >>> surer(0.3, 0.4, math.nan)
    0.4
    """
    return max((p for p in probabilities if p == p), default=math.nan)


def either(*probabilities: float) -> float:
    """That at least one of independent things is so; of the known ones; NaN if none is known."""
    none, known = 1.0, False
    for probability in probabilities:
        if probability == probability:
            none *= 1.0 - probability
            known = True
    return 1.0 - none if known else math.nan
