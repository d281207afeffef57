"""How measurements speak for or against a gesture.

Each measurement is weighed as a log likelihood ratio: positive speaks for the gesture, negative
against it, 0 says nothing. It grows in proportion to how far the measurement lies from the value
at which it is undecided, as for two normal distributions of equal spread, and it is limited, as
no single measurement is beyond doubt. Noise in the measurement widens both distributions, so
that evidence from bad input fades to nothing and the probability to its prior. What is unknown
says nothing, and neither does it count as known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple


class Weighing(NamedTuple):
    """How one kind of measurement is weighed."""

    even: float  # the value that says nothing, in the measurement's unit
    scale: float  # so far from there the evidence is e : 1; its sign tells which way it speaks
    least: float  # limits of the log likelihood ratio
    most: float

    def evidence(self, value: float, noise: float = 0.0) -> float:
        """The log likelihood ratio of a measurement; NaN where it is unknown.

        Args:
            value: the measurement.
            noise: its standard deviation, in the same unit.
        """
        share = noise / self.scale
        ratio = (value - self.even) / self.scale / (1.0 + share * share)
        if ratio > self.most:
            return self.most
        return self.least if ratio < self.least else ratio  # NaN stays NaN


def posterior(prior: float, evidence: Sequence[float]) -> float:
    """The probability of a gesture, given evidence that is NaN where it is unknown.

    Args:
        prior: its probability without evidence.
        evidence: log likelihood ratios.

    Returns:
        NaN where nothing is known.
    """
    known = [ratio for ratio in evidence if ratio == ratio]
    if not known:
        return math.nan
    return logistic(math.log(prior / (1.0 - prior)) + sum(known))


def logistic(odds: float) -> float:
    """The probability of log odds."""
    if odds < -700.0:  # its exponential is past floating point
        return 0.0
    return 1.0 / (1.0 + math.exp(-odds))


def either(*probabilities: float) -> float:
    """That at least one of independent things is so; of the known ones; NaN if none is known."""
    none, known = 1.0, False
    for probability in probabilities:
        if probability == probability:
            none *= 1.0 - probability
            known = True
    return 1.0 - none if known else math.nan
