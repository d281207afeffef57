"""How observations depend on the phase: the two families of emissions.

**gaussian** is the thesis's (2.2): every feature of every phase has a normal distribution of its
own, gestures included.

**robust** differs in two ways. The four measured features have contaminated normal distributions
(Tukey 1960): with a small probability a value comes from nowhere in particular, so that a single
wild one cannot outweigh all that was seen before. And a gesture's value g is taken for what it
is, the probability that the gesture is there, from a detector that knows how often it is in
general, r, but not the phase. The phase has a probability q of its own for it, so that the
general rate has to go out again before q comes in: the likelihood of the value is
q g / r + (1 - q)(1 - g) / (1 - r), the virtual evidence of Pearl (1988). For keys, g = 0 or 1,
that is Bernoulli's distribution but for a factor which no phase changes.

A feature that is NaN is unknown and marginalised: it drops out of the product of Algorithm 1,
line 6.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from kendon.observations import GESTURE_RATES
from kendon.person import FloatArray

_LOG_2PI = math.log(2 * math.pi)

#: The measured features come first; from here on they are gestures.
GESTURES_FROM = 4

#: A density that is smaller than another by this logarithm is lost in their sum.
_LOST = math.log(1e-17)

#: The range over which a value "from nowhere in particular" spreads: 12 m of distance, -2 to
#: 4 m/s, the gaze's 0 to 2, the smile's 0 to 5.
RANGES: tuple[float, ...] = (12.0, 6.0, 2.0, 5.0)


class Family(StrEnum):
    """A family of emissions."""

    GAUSSIAN = "gaussian"
    ROBUST = "robust"


def gesture_likelihoods(there: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Likelihoods of a gesture that is surely absent, g = 0, and surely present, g = 1.

    Args:
        there: (..., 3), the probability q that each gesture is there.
    """
    rates = np.array(GESTURE_RATES)
    return (1 - there) / (1 - rates), there / rates


@dataclass(frozen=True, eq=False)
class Emissions:
    """The emissions of a model, prepared for evaluation.

    Args:
        means: (K, F); of a robust gesture, the probability q that it is there.
        variances: (K, F), positive; of a robust gesture not used.
        family: which family.
        outliers: probability of a value from nowhere in particular, robust only.
    """

    means: FloatArray
    variances: FloatArray
    family: Family = Family.GAUSSIAN
    outliers: float = 0.0
    _rows: tuple[tuple[tuple[float, float, float], ...], ...] = field(init=False, repr=False)
    _nowhere: tuple[float, ...] = field(init=False, repr=False)  # log density of an outlier

    def __post_init__(self) -> None:
        log_norm = -0.5 * (_LOG_2PI + np.log(self.variances))
        terms = np.stack([self.means, -0.5 / self.variances, log_norm], axis=-1)
        if self.family is Family.ROBUST:
            terms[:, :GESTURES_FROM, 2] += math.log1p(-self.outliers)
            absent, present = gesture_likelihoods(self.means[:, GESTURES_FROM:])
            terms[:, GESTURES_FROM:, 0], terms[:, GESTURES_FROM:, 1] = absent, present
        rows = tuple(tuple(tuple(term) for term in row) for row in terms.tolist())
        nowhere = (math.log(self.outliers / r) if self.outliers else -math.inf for r in RANGES)
        object.__setattr__(self, "_rows", rows)
        object.__setattr__(self, "_nowhere", tuple(nowhere))

    def log_likelihood(self, x: list[float]) -> list[float]:
        """Log P(x | phase) of each phase over the known features of x.

        Lists, not arrays: see the remark in `kendon.models.hmm`.
        """
        if self.family is Family.ROBUST:
            known = [
                (i, value, nowhere)
                for i, (value, nowhere) in enumerate(zip(x, self._nowhere, strict=False))
                if value == value
            ]
            # Probabilities, whatever a detector's arithmetic makes of them.
            keys = [
                (i, min(max(v, 0.0), 1.0))
                for i, v in enumerate(x[GESTURES_FROM:], GESTURES_FROM)
                if v == v
            ]
            return [self._robust(row, known, keys) for row in self._rows]
        totals = []
        for row in self._rows:
            total = 0.0
            for (mean, precision, log_norm), value in zip(row, x, strict=True):
                if value == value:  # NaN is unequal to itself
                    difference = value - mean
                    total += log_norm + precision * difference * difference
            totals.append(total)
        return totals

    @staticmethod
    def _robust(
        row: tuple[tuple[float, float, float], ...],
        measured: list[tuple[int, float, float]],
        gestures: list[tuple[int, float]],
    ) -> float:
        """Log P(x | phase) of one phase.

        Args:
            row: the phase's terms of every feature.
            measured: the known features' places, values and log densities of an outlier.
            gestures: the known gestures' places and values.
        """
        total = 0.0
        for i, value, nowhere in measured:
            mean, precision, log_norm = row[i]
            difference = value - mean
            normal = log_norm + precision * difference * difference
            more, less = (normal, nowhere) if normal > nowhere else (nowhere, normal)
            total += more
            if less - more > _LOST:
                total += math.log1p(math.exp(less - more))
        shown = 1.0
        for i, value in gestures:
            absent, present, _ = row[i]
            shown *= absent + (present - absent) * value
        return total + math.log(shown)

    def log_likelihoods(self, X: FloatArray) -> FloatArray:
        """Log P(x_t | phase) of every step over its known features, shape (T, K).

        Row by row, as the tracker does, so that both give the same numbers to the last bit.
        """
        rows = [self.log_likelihood(x) for x in X.tolist()]
        return np.array(rows).reshape(len(X), len(self.means))
